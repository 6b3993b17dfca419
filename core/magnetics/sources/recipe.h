// Recipe of a source or of a magnetisable body: the data to recreate it, to compare it with others
// and to store it.
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

  std::string kind;  // name of the function of loomstone.magnetics to call; empty if none
  std::vector<std::pair<std::string, Value>> values;  // arguments of function `kind`, in SI units
  std::shared_ptr<const TriangleMesh> mesh;           // mesh in the axes of the body [m], or null
  // For a magnet divided into cells: recipe of the undivided magnet. Otherwise null.
  std::shared_ptr<const SourceRecipe> of;
};

}  // namespace loomstone
