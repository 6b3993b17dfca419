// Raw and smoothed unstructured meshes for tests: Delaunay triangulation of seeded random points,
// nothing improved.
#pragma once

#include "core/base/types.h"

namespace loomstone::test {

// Points (n x 3, z = 0) of a rectangle that has its four corners among them. Bowyer, Comput. J. 24
// (1981).
Triangles delaunay(const Points& points);

// Rectangle [x0, x1] x [0, width]: boundary points at distance h, inside one random point in each
// cell of h x h. smoothing: rounds of moving inner points to the mean of their neighbours (0: raw,
// with slivers).
struct PointMesh {
  Points points;
  Triangles triangles;
  double least_angle;  // [rad]
};
PointMesh random_mesh(double x0, double x1, double width, double h, unsigned seed, int smoothing);

}  // namespace loomstone::test
