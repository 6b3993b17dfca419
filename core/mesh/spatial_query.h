// Closest-point queries and inside tests on a triangle surface (Embree). Queries are thread-safe
// between refits.
#pragma once

#include <memory>

#include "core/base/types.h"

namespace loomstone {

struct ClosestPoint {
  Index triangle = -1;              // -1: nothing within the radius
  Vec3 point = Vec3::Zero();        // [m]
  Vec3 barycentric = Vec3::Zero();  // [1]
  Vec3 normal = Vec3::Zero();       // unit pseudo-normal of the closest feature; 0: undefined
  double distance = 0.0;            // [m], >= 0
};

class SpatialQuery {
 public:
  SpatialQuery(const Points& vertices, const Triangles& triangles);
  ~SpatialQuery();
  SpatialQuery(SpatialQuery&&) noexcept;
  SpatialQuery& operator=(SpatialQuery&&) noexcept;

  void refit(const Points& vertices);  // sets new vertex positions
  // Returns the closest point within `radius` [m], or a result with triangle -1 if there is none.
  // If several triangles are equally close, returns the point on the one with the smallest index.
  ClosestPoint closest(const Vec3& point, double radius) const;
  // Returns whether the point is inside the surface: on the side of the closest feature that is
  // opposite to the feature's pseudo-normal. The surface must be closed.
  bool inside(const Vec3& point) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace loomstone
