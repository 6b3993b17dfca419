// Constants of the mid-edge bending element. As in [Morley1968], the curvature of a triangle
// follows from the slopes at its edge midpoints. The slope at an interior edge is a fixed linear
// combination of the hinge angles of the two triangles at the edge. Except next to slivers and
// prescribed triangles, its weights are those of least norm that reproduce every constant curvature
// without moments across boundary edges. The curvature of each triangle is therefore a fixed linear
// function of at most nine hinge angles. Vertex positions remain the only unknowns, and results
// hardly depend on the directions of the mesh edges. The element itself is not taken from the
// literature.
#pragma once

#include <array>
#include <vector>

#include "core/cloth/bending/bending.h"

namespace loomstone::midedge {

// Element of one triangle. Its curvature in weft/warp axes is the sum over s of
// curvature[s] * (theta - rest)[hinge[s]].
struct Element {
  int n_hinges = 0;
  std::array<Index, 9> hinge{};
  std::array<Vec3, 9> curvature{};  // (kxx, kyy, 2 kxy) per hinge angle [1/m]
  // Rest area times rigidity, condensed so that moments across boundary edges vanish [N m^3].
  Mat3 rigidity = Mat3::Zero();
};

struct Elements {
  std::vector<Element> elements;  // one per triangle
  Index n_averaged = 0;           // edges with the mean slope, because |weight| would exceed 1
};

// Makes the elements of a setup that check_bending_setup() has accepted.
Elements make_elements(const BendingSetup& setup, const EdgeTable& edges,
                       const std::vector<Hinge>& hinges);

}  // namespace loomstone::midedge
