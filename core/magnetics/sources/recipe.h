// The recipe of a source or of a body that magnetises: enough to make it again, to compare it and
// to write it down.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/base/types.h"
#include "core/mesh/triangle_mesh.h"

namespace loomstone {

struct SourceRecipe {
  using Value = std::variant<double, Vec3, Points>;

  std::string kind;  // as its function in loomstone.magnetics is called; empty: none makes it
  std::vector<std::pair<std::string, Value>> values;  // by argument, SI units
  std::shared_ptr<const TriangleMesh> mesh;           // of a mesh, about its centre [m]
  std::shared_ptr<const SourceRecipe> of;             // the magnet that cells divide
};

}  // namespace loomstone
