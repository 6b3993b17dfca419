// Vertex normals of smooth surfaces (CollisionSurface::smooth). The normals of a surface are
// computed again only if it has moved.
#pragma once

#include "core/base/bytes.h"
#include "core/base/types.h"
#include "core/collision/model/collision_model.h"

namespace loomstone {

class SmoothNormals {
 public:
  // Computes the area-weighted unit vertex normals of smooth surfaces at x. Returns this object.
  const SmoothNormals& at(const CollisionModel& model, const Points& x);
  bool empty() const { return normals_.rows() == 0; }  // true: at() has found no smooth surface
  // Returns the normal of a vertex of a smooth surface.
  auto of(Index vertex) const { return normals_.row(vertex - first_); }
  std::size_t bytes() const { return bytes_of(x_, normals_); }

 private:
  // Row 0 of x_ and of normals_ belongs to vertex first_, the first vertex of the first smooth
  // surface.
  Index first_ = 0;
  Points x_;  // positions for which the normals were computed [m]
  Points normals_;
};

}  // namespace loomstone
