// Unstructured meshes for tests: Delaunay triangulations of seeded random points, raw or smoothed.
#pragma once

#include "core/base/types.h"

namespace loomstone::test {

// Triangulates points (n x 3, z = 0) of a rectangle by the algorithm of Bowyer, Comput. J. 24
// (1981). The points must include the four corners of the rectangle.
Triangles delaunay(const Points& points);

// Mesh of the rectangle [x0, x1] x [0, width] with boundary points spaced about h apart. The cell
// around each inner node of a grid with the same spacing contains one random point. Each round of
// smoothing moves every inner point to the mean of its neighbours and triangulates all points
// again. Without smoothing, the mesh can contain slivers.
struct PointMesh {
  Points points;
  Triangles triangles;
  double least_angle;  // [rad]
};
PointMesh random_mesh(double x0, double x1, double width, double h, unsigned seed, int smoothing);

}  // namespace loomstone::test
