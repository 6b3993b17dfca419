// Contacts with friction as terms of the implicit solve: two-stage repulsion along the normal,
// anchored springs across it.
#pragma once

#include "core/collision/model/collision_model.h"
#include "core/collision/model/contact.h"
#include "core/collision/response/response_inputs.h"
#include "core/linalg/extra_terms.h"
#include "core/parallel/team.h"

namespace loomstone {

// What the force of one contact follows from over a step, and is not in its term. The gap is
// measured along the normal of the start: pairs, weights, normals and anchors are fixed over a
// step.
struct ContactLaw {
  Vec3 normal;
  double distance, thickness;  // at the start [m]
  double share, friction;      // [1]
  Vec3 slip;                   // of the anchor at the start [m]
  double limit;                // of the friction force [N]
};

// The terms of a step's contacts, in the order of the contacts. They stand first among the terms of
// a solve. Pairs, weights, normals and anchors stay those of the start of the step.
class ContactTerms {
 public:
  ContactTerms() = default;
  // Appends a term to `terms` for each contact that moves a row and carries a share.
  ContactTerms(const CollisionModel& model, const ContactInputs& inputs,
               const std::vector<Contact>& contacts, const ContactState& state, ExtraTerms& terms);

  std::size_t size() const { return laws_.size(); }
  double energy() const { return energy_; }  // of normal forces and anchors at the start [J]

  // Gradient and hessian of the first size() terms where rows have moved by `displacement` (rows x
  // 3) [m] in `time` [s], normal and friction force evaluated there. Returns their energy [J],
  // whose gradient they are while limits stay. A request of NewLimits changes the limits of
  // friction.
  double at(const Team& team, const Points& displacement, double time, TermRequest request,
            ExtraTerms& terms);

  // Terms about the start again, with the friction that belongs to where rows have moved: its limit
  // follows from the normal force there, its secant from the slip. Returns the sum of what was
  // wrong with the friction of `terms` over that of limits [1]. inverse_mass: of cloth rows [1/kg],
  // from which follows how far a contact slips that is held too much.
  double friction_at(const Team& team, const Points& displacement, double time,
                     const Vector& inverse_mass, ExtraTerms& terms) const;

  // Anchors after the motion x0 -> x1, sorted like the contacts (those that the terms were made
  // of); pairs that are no contacts have none.
  std::vector<ContactState::Anchor> anchors(const CollisionModel& model,
                                            const std::vector<Contact>& contacts, const Points& x0,
                                            const Points& x1) const;

 private:
  std::vector<ContactLaw> laws_;  // of each term
  std::vector<double> shares_;    // of the force that each contact carries [1]
  std::vector<Vec3> slips_;       // of each contact's anchor at the start [m]
  double stiffness_ = 0.0;        // of a full contact [N/m]
  Index n_cloth_ = 0;
  double energy_ = 0.0;
};

}  // namespace loomstone
