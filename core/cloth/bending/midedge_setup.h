// The constants of the mid-edge bending element: the curvature of each triangle as a fixed linear
// function of the angles of at most nine hinges. Our own element: as in [Morley1968], the curvature
// of a triangle follows from the slopes at the middles of its edges. The slope of an edge is a
// fixed combination of the hinge angles of its two triangles, with the smallest weights that
// reproduce every constant curvature. Positions remain the only unknowns, and the direction of the
// mesh has no influence.
#pragma once

#include <array>
#include <vector>

#include "core/cloth/bending/bending.h"

namespace loomstone::midedge {

// One triangle: kappa = sum_s curvature[s] (theta - rest)[hinge[s]] in its weft/warp axes.
struct Element {
  int n_hinges = 0;
  std::array<Index, 9> hinge{};
  std::array<Vec3, 9> curvature{};  // (kxx, kyy, 2 kxy) per angle [1/m]
  // Rest area times rigidity, without moments across boundary edges [N m^3].
  Mat3 rigidity = Mat3::Zero();
};

struct Elements {
  std::vector<Element> elements;  // one per triangle
  Index n_averaged = 0;  // edges that take the plain mean slope because weights would exceed 1
};

// The setup has passed check_bending_setup.
Elements make_elements(const BendingSetup& setup, const EdgeTable& edges,
                       const std::vector<Hinge>& hinges);

}  // namespace loomstone::midedge
