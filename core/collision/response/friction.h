// Friction by anchored tangential springs with return mapping (decisions: terms of the implicit
// solve).
#pragma once

#include <vector>

#include "core/collision/model/collision_model.h"
#include "core/collision/model/contact.h"

namespace loomstone {

// Gradient [N] and positive semidefinite Hessian [N/m] of a spring of stiffness k [N/m] that slips
// at `limit` = mu N [N]. slip: s, of side a relative to b, tangential [m]; predicted: u = h v_t,
// tangential [m]; tangent: projector T.
struct FrictionResponse {
  Vec3 gradient;
  Mat3 hessian;
};
FrictionResponse friction_response(const Vec3& slip, const Vec3& predicted, const Mat3& tangent,
                                   double stiffness, double limit);

// The slip u of a step, where the last one was shorter by `gained`: a contact that slides on and
// speeds up is expected to go on so, at most to twice the slip. Without this the secant stiffness,
// which belongs to the speed of the step before, makes friction too large by h / t of itself after
// a time t of sliding.
Vec3 sped_up(const Vec3& slip, const Vec3& predicted, const Vec3& gained, double stiffness,
             double limit);

// The same where the contact has moved by u, without linearisation: force, its derivative for
// constant limit (secant: the stiffness limit / |s + u| in every direction while slipping), energy
// [J] (that of the spring up to the limit, work against the limit beyond).
struct FrictionState {
  Vec3 gradient;
  Mat3 hessian;
  double energy;
};
FrictionState friction_at(const Vec3& slip, const Vec3& moved, const Mat3& tangent,
                          double stiffness, double limit, bool secant);

// Slip after the step: s + u of the actual motion, clipped to limit / k.
Vec3 slip_after(const Vec3& slip, const Vec3& actual, double stiffness, double limit);

// Slip of each contact at the start of the step, in its tangent plane: that of the same pair, else
// that of the pair from which the vertex (edge) came: same side a, or same side b, with a
// neighbouring feature of the other side.
std::vector<Vec3> anchored_slips(const std::vector<Contact>& contacts, const CollisionModel& model,
                                 const ContactState& state);

}  // namespace loomstone
