// The constants of the mid-edge bending element: curvature of each triangle as a fixed linear
// function of the angles of at most nine hinges. Our own element: the curvature of a triangle from
// the slopes at the middles of its edges is Morley's [Morley1968]; the slope of an edge is here a
// fixed combination of the hinge angles of its two triangles, with the smallest weights that
// reproduce every constant curvature. No unknowns beside positions, no dependence on the direction
// of the mesh.
#pragma once

#include <array>
#include <vector>

#include "core/cloth/bending/bending.h"

namespace loomstone::midedge {

// One triangle. kappa = sum_s curvature[s] (theta - rest)[hinge[s]] in the triangle's weft/warp
// axes.
struct Element {
  int n_hinges = 0;
  std::array<Index, 9> hinge{};
  std::array<Vec3, 9> curvature{};  // (kxx, kyy, 2 kxy) per angle [1/m]
  Mat3 rigidity =
      Mat3::Zero();  // rest area times rigidity, moment-free across boundary edges [N m^3]
};

struct Elements {
  std::vector<Element> elements;  // one a triangle
  Index n_averaged = 0;  // edges whose slope is the plain mean because the weights would exceed 1
};

// The setup has passed check_bending_setup.
Elements make_elements(const BendingSetup& setup, const EdgeTable& edges,
                       const std::vector<Hinge>& hinges);

}  // namespace loomstone::midedge
