// Adaptive quadrature of one source's field over the panels of another: tensor Gauss rules on
// panels that are bisected, in the direction with the larger error, until the estimated error is
// below the tolerance. The error of an n-point rule is a Legendre coefficient of degree 2 n; it is
// estimated as the square of the last coefficients of the rule over the largest.
#pragma once

#include <vector>

#include "core/base/rotation.h"
#include "core/magnetics/sources/source.h"

namespace loomstone {

using Vec6 = Eigen::Matrix<double, 6, 1>;

// wrench: force [N], then torque about the centre of the panels' body divided by its radius [N], in
// the axes of `by`. energy: minus the integral of M.mu0 H over the volume inside the panels [J], as
// the first of six components. Because div H = 0 outside the source, that is the integral of
// -(M.x) mu0 H.n over the closed surface.
enum class PanelQuantity { wrench, energy };

struct PanelIntegral {
  Vec6 value = Vec6::Zero();
  double error = 0.0;  // estimated norm of the error
};

// Largest number of field evaluations for one pair; the value reached then is returned with its
// error.
inline constexpr Index most_evaluations = 2000000;

// The source whose field is integrated, and the panels.
struct PanelTask {
  const Source& by;
  const std::vector<Panel>& panels;
  RigidPose pose;  // of the panels in the axes of `by`
  double radius;   // of their body [m]
  PanelQuantity quantity;
};

// Error at most `tolerance` times the larger of the value and `least`.
PanelIntegral integrate_panels(const PanelTask& task, double tolerance, double least);

}  // namespace loomstone
