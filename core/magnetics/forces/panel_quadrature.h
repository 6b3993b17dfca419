// Integrals of one source's field over the panels of another: tensor Gauss rules, halved in the
// direction that needs it until the estimated error is below the tolerance. The estimate of a panel
// and direction is the square of the last Legendre coefficients over the largest, as the error of
// an n-point rule is a coefficient of degree 2 n.
#pragma once

#include <vector>

#include "core/base/rotation.h"
#include "core/magnetics/sources/source.h"

namespace loomstone {

using Vec6 = Eigen::Matrix<double, 6, 1>;

// wrench: force [N], then torque about the centre of the panels' body over its radius [N], in the
// axes of `by`. energy: - integral of M.mu0 H over the volume inside the panels [J], the first of
// the six: as div H = 0 off the source, it is that of - (M.x) mu0 H.n over the closed surface.
enum class PanelQuantity { wrench, energy };

struct PanelIntegral {
  Vec6 value = Vec6::Zero();
  double error = 0.0;  // estimated, of the norm of the value
};

// Most evaluations of a field for one pair; what is reached then is returned with its error.
inline constexpr Index most_evaluations = 2000000;

// Whose field is integrated over which panels.
struct PanelTask {
  const Source& by;
  const std::vector<Panel>& panels;
  RigidPose pose;  // of the panels in the axes of `by`
  double radius;   // of their body [m]
  PanelQuantity quantity;
};

// To `tolerance` times the larger of the value and of `least`.
PanelIntegral integrate_panels(const PanelTask& task, double tolerance, double least);

}  // namespace loomstone
