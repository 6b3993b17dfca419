// Vertex normals of smooth surfaces. They are kept until the surface moves.
#pragma once

#include "core/base/bytes.h"
#include "core/base/types.h"
#include "core/collision/model/collision_model.h"

namespace loomstone {

class SmoothNormals {
 public:
  // Returns area-weighted unit vertex normals of smooth surfaces at x. Rows of other vertices are
  // unused. Without smooth surfaces, there are no rows. The reference is valid until the next call.
  const Points& at(const CollisionModel& model, const Points& x);
  std::size_t bytes() const { return bytes_of(x_, normals_); }

 private:
  Points x_;  // positions for which the normals were computed [m]
  Points normals_;
};

}  // namespace loomstone
