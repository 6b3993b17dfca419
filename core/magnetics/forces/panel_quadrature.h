// Adaptive quadrature of one source's field over the panels of another, by tensor-product Gauss
// rules. Panels are bisected, in the direction with the larger error, until the estimated total
// error meets the tolerance or most_evaluations is exceeded. The error of an n-point rule is about
// the Legendre coefficient of degree 2 n of the integrand. Coefficients are assumed to decay
// geometrically. Let l be the larger of the last two coefficients that the rule resolves, and c the
// largest of all that it resolves. The estimated error is then 2 l^2 / c. A panel with many parts
// is cut where the field is singular, if these places are known (cut_panels.h).
#pragma once

#include <vector>

#include "core/base/rotation.h"
#include "core/magnetics/sources/source.h"

namespace loomstone {

using Vec6 = Eigen::Matrix<double, 6, 1>;

// `wrench` is the force [N], followed by the torque about the centre of the panels' body divided by
// PanelTask::radius [N], both in the axes of PanelTask::by. Rigid bodies in contact overlap by
// rounding errors and by the contact solver's tolerance. The normal component of H jumps at a
// charged face, so charge inside the body `by` experiences the field at the nearest point outside
// this body. `energy` is minus the integral of M.B over the volume inside the panels [J], where M
// is the magnetisation. The energy is the first of the six components; the others are 0. Because
// div B = 0 and M is uniform, the energy equals minus the integral of (M.x)(B.n) over the closed
// surface. B.n does not jump at charged faces.
enum class PanelQuantity { wrench, energy };

struct PanelIntegral {
  Vec6 value = Vec6::Zero();
  double error = 0.0;  // estimated norm of the error
};

// Number of field evaluations in one integral above which panels are no longer bisected. The
// current value and its error are then returned. With n points in a direction, every part of a
// panel counts as n^2 evaluations, even on a line, where only n are done.
inline constexpr Index most_evaluations = 2000000;

// Arguments of an integral: `quantity` is integrated over `panels` in the field of the source `by`.
struct PanelTask {
  const Source& by;
  const std::vector<Panel>& panels;
  RigidPose pose;  // pose of the panels in the axes of `by`
  double radius;   // radius of the panels' body [m]
  PanelQuantity quantity;
};

// Integrates over the panels. Unless most_evaluations is exceeded, the estimated error is at most
// `tolerance` times the largest of four numbers: the norm of the first three components of the
// value, that of the last three, `least`, and 1e-6 times the sum of the norms of the integrals over
// all parts of panels.
PanelIntegral integrate_panels(const PanelTask& task, double tolerance, double least);

}  // namespace loomstone
