// Coulomb friction by anchored tangential springs with return mapping (method.md, contact
// terms).
#pragma once

#include <vector>

#include "core/collision/model/collision_model.h"
#include "core/collision/model/contact.h"

namespace loomstone {

// Gradient [N] and positive semidefinite Hessian [N/m] of a spring of stiffness k [N/m] that slips
// at `limit` = mu N [N]. slip: s, of side a relative to b, tangential [m]; predicted: u = h v_t,
// tangential [m]; tangent: projector T on the tangent plane.
struct FrictionResponse {
  Vec3 gradient;
  Mat3 hessian;
};
FrictionResponse friction_response(const Vec3& slip, const Vec3& predicted, const Mat3& tangent,
                                   double stiffness, double limit);

// Extrapolates the slip u of a sliding contact that gained `gained` over the last step, at most to
// twice the slip. Otherwise the secant stiffness lags one step behind an accelerating contact:
// after a time t of sliding, friction is too large by the fraction h / t.
Vec3 sped_up(const Vec3& slip, const Vec3& predicted, const Vec3& gained, double stiffness,
             double limit);

// The same after a displacement u, without linearisation: force, its derivative at constant limit
// (secant: stiffness limit / |s + u| in all directions while slipping), and energy [J] (of the
// spring up to the limit, then work against the limit).
struct FrictionState {
  Vec3 gradient;
  Mat3 hessian;
  double energy;
};
FrictionState friction_at(const Vec3& slip, const Vec3& moved, const Mat3& tangent,
                          double stiffness, double limit, bool secant);

// Slip after a step with the actual displacement u: s + u, clipped to limit / k.
Vec3 slip_after(const Vec3& slip, const Vec3& actual, double stiffness, double limit);

// Slip of each contact at the start of the step, in its tangent plane: from the anchor of the same
// pair, else from the anchor of a neighbouring pair, which has one side in common and a
// neighbouring feature on the other.
std::vector<Vec3> anchored_slips(const std::vector<Contact>& contacts, const CollisionModel& model,
                                 const ContactState& state);

}  // namespace loomstone
