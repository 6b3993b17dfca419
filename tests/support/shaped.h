// Lifts a mesh to heights given by a function of x and y; rest coordinates are unchanged.
#pragma once

#include "core/mesh/triangle_mesh.h"

namespace loomstone::test {

inline TriangleMesh shaped(const TriangleMesh& mesh, double (*height)(double, double)) {
  Points x = mesh.vertices();
  for (Index i = 0; i < x.rows(); ++i) x(i, 2) = height(x(i, 0), x(i, 1));
  return TriangleMesh(x, mesh.triangles(), mesh.uv(), mesh.uv_triangles());
}

}  // namespace loomstone::test
