// Constants of the mid-edge bending element. As in [Morley1968], the curvature of a triangle
// follows from the slopes at its edge midpoints. The slope at an interior edge is a fixed linear
// combination of the hinge angles of the two triangles at the edge. Its weights have the least norm
// with which the slope is exact for every constant curvature that causes no moment across boundary
// edges. Other weights apply to edges of triangles whose vertices are all prescribed, and to edges
// that would otherwise get a weight above 1 in magnitude, for example at slivers. In all cases, the
// curvature of each triangle is a fixed linear function of at most nine hinge angles. Vertex
// positions remain the only unknowns, and results hardly depend on the directions of the mesh
// edges. This element is not taken from the literature.
#pragma once

#include <array>
#include <vector>

#include "core/cloth/bending/bending.h"

namespace loomstone::midedge {

// Bending element of one triangle. The change of its curvature from rest, in weft/warp axes, has
// two parts. One is the sum of curvature[s] * (theta - rest)[hinge[s]] over s, with the hinge
// angles theta and their rest angles. The other is caused by the slopes at boundary edges;
// `rigidity` accounts for it.
struct Element {
  int n_hinges = 0;
  std::array<Index, 9> hinge{};
  std::array<Vec3, 9> curvature{};  // (kxx, kyy, 2 kxy) per hinge angle [1/m]
  // Rest area times rigidity, condensed so that moments across boundary edges vanish [N m^3].
  Mat3 rigidity = Mat3::Zero();
};

struct Elements {
  std::vector<Element> elements;  // one per triangle
  // Number of edges whose slope is the mean of the slopes of their two triangles, because a weight
  // would exceed 1 in magnitude.
  Index n_averaged = 0;
};

// Makes the elements of a setup that check_bending_setup() has accepted.
Elements make_elements(const BendingSetup& setup, const EdgeTable& edges,
                       const std::vector<Hinge>& hinges);

}  // namespace loomstone::midedge
