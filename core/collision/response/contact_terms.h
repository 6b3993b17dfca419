// Contacts with friction as terms of the implicit solve: two-stage repulsion along the normal,
// anchored tangential springs (method.md, contact terms).
#pragma once

#include "core/collision/model/collision_model.h"
#include "core/collision/model/contact.h"
#include "core/collision/response/response_inputs.h"
#include "core/linalg/extra_terms.h"
#include "core/parallel/team.h"

namespace loomstone {

// Data of one contact that its term does not hold. The gap is measured along the normal of the
// start: pairs, weights, normals and anchors are fixed during a step.
struct ContactLaw {
  Vec3 normal;
  double distance, thickness;  // at the start [m]
  double share, friction;      // [1]
  Vec3 slip;                   // of the anchor at the start [m]
  double limit;                // largest friction force, mu N [N]
};

// The terms of a step's contacts, in the order of the contacts. They come first among the terms of
// a solve.
class ContactTerms {
 public:
  ContactTerms() = default;
  // Appends a term to `terms` for each contact that moves a row and carries a share.
  ContactTerms(const CollisionModel& model, const ContactInputs& inputs,
               const std::vector<Contact>& contacts, const ContactState& state, ExtraTerms& terms);

  std::size_t size() const { return laws_.size(); }
  double energy() const { return energy_; }  // of normal forces and anchors at the start [J]

  // Updates the first size() of `terms` to normal and friction forces where rows have moved by
  // `displacement` (rows x 3) [m] in `time` [s]. Returns their energy [J]; its gradient are the
  // forces for constant friction limits. TermRequest::NewLimits recomputes these limits.
  double at(const Team& team, const Points& displacement, double time, TermRequest request,
            ExtraTerms& terms);

  // Linearises the terms at the start again, with friction for that displacement: the limit follows
  // from the normal force there, the secant stiffness from the slip. Returns the sum of the errors
  // of the friction in `terms`, relative to the sum of limits [1]. inverse_mass: of cloth rows
  // [1/kg], to predict the slip of a contact whose friction was too large.
  double friction_at(const Team& team, const Points& displacement, double time,
                     const Vector& inverse_mass, ExtraTerms& terms) const;

  // Friction anchors after the motion x0 -> x1, one for each of `contacts`, which must be those of
  // the constructor.
  std::vector<ContactState::Anchor> anchors(const CollisionModel& model,
                                            const std::vector<Contact>& contacts, const Points& x0,
                                            const Points& x1) const;

 private:
  std::vector<ContactLaw> laws_;  // of each term
  std::vector<double> shares_;    // of each contact [1]
  std::vector<Vec3> slips_;       // of each contact's anchor at the start [m]
  double stiffness_ = 0.0;        // of a full contact [N/m]
  Index n_cloth_ = 0;
  double energy_ = 0.0;
};

}  // namespace loomstone
