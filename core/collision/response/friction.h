// Coulomb friction by anchored tangential springs with return mapping (method.md, Friction).
#pragma once

#include <vector>

#include "core/collision/model/collision_model.h"
#include "core/collision/model/contact.h"

namespace loomstone {

// Linearised friction of a tangential spring. After a tangential displacement d in the step, the
// gradient of the energy (see FrictionState) is `gradient` [N] + `hessian` [N/m] d. The Hessian is
// positive semi-definite. In the functions below, the spring has the stiffness k [N/m] and slips
// when its force reaches `limit`, which is mu times the normal force [N]. `slip` is the tangential
// displacement s of feature a relative to feature b, from the anchor, at the start of the step [m].
// `predicted` is the predicted tangential displacement u = h v_t [m] in the step h, with the
// predicted tangential velocity v_t. `tangent` is the projector T onto the tangent plane.
struct FrictionResponse {
  Vec3 gradient;
  Mat3 hessian;
};
FrictionResponse friction_response(const Vec3& slip, const Vec3& predicted, const Mat3& tangent,
                                   double stiffness, double limit);

// Returns `predicted`, extrapolated if the contact slides in the direction of its slip. `gained` is
// the length of the step times the change of the tangential velocity in the last step, scaled to
// this step [m]. Extrapolation adds the component of `gained` along `predicted` if this component
// is positive, but at most `predicted` itself. Without extrapolation, the secant stiffness lags one
// step behind an accelerating contact. After a sliding time t, friction would then be too large by
// the fraction h / t, where h is the step.
Vec3 sped_up(const Vec3& slip, const Vec3& predicted, const Vec3& gained, double stiffness,
             double limit);

// Friction after a given displacement u (`moved`), without linearisation. The Hessian is the
// derivative of the gradient at constant limit. With `secant`, the Hessian of a slipping contact is
// instead the stiffness limit / |s + u| in all tangential directions. The energy [J] is the elastic
// energy of the spring up to the limit, plus the work against the limit.
struct FrictionState {
  Vec3 gradient;
  Mat3 hessian;
  double energy;
};
FrictionState friction_at(const Vec3& slip, const Vec3& moved, const Mat3& tangent,
                          double stiffness, double limit, bool secant);

// Returns the slip after a step: slip + actual, scaled down to the length limit / stiffness if it
// is longer. `actual` is the actual tangential displacement in the step [m].
Vec3 slip_after(const Vec3& slip, const Vec3& actual, double stiffness, double limit);

// Returns the slip [m] of each contact at the start of the step, projected onto its tangent plane.
// The slip comes from the anchor of the contact's feature pair. If this pair has no anchor, the
// slip comes from the neighbouring pair whose anchor has the largest normal force. A neighbouring
// pair has the same vertex, first edge or second edge, and the other features of the two pairs have
// a common vertex. If no neighbouring pair has an anchor either, the slip is zero.
std::vector<Vec3> anchored_slips(const std::vector<Contact>& contacts, const CollisionModel& model,
                                 const ContactState& state);

}  // namespace loomstone
