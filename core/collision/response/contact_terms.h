// Contacts with friction as terms of the implicit solve: two-stage repulsion along the normal,
// anchored springs across it.
#pragma once

#include "core/collision/model/collision_model.h"
#include "core/collision/model/contact.h"
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

// What contacts had at the start of the step.
struct ContactStart {
  std::vector<double> shares;  // of the force each carries [1]
  std::vector<Vec3> slips;     // of the anchors [m]
};

// laws: one a term added.
void contact_terms(const CollisionModel& model, const std::vector<Contact>& contacts,
                   const Points& x0, const Points& v0, const Points& last_change,
                   const Points& body_centres, double step, Index n_cloth,
                   const ContactState& state, ExtraTerms& terms, std::vector<ContactLaw>& laws,
                   ContactStart& start, double& energy);

// Gradient and hessian of the first laws.size() terms where rows have moved by `displacement` (rows
// x 3) [m] in `time` [s], normal and friction force evaluated there. Returns their energy [J],
// whose gradient they are while limits stay.
double contact_terms_at(const Team& team, std::vector<ContactLaw>& laws, double stiffness,
                        const Points& displacement, double time, TermRequest request,
                        ExtraTerms& terms);

// Terms about the start again, with the friction that belongs to where rows have moved: its limit
// follows from the normal force there, its secant from the slip. Returns the sum of what was wrong
// with the friction of `terms` over that of limits [1]. inverse_mass: of cloth rows [1/kg], from
// which follows how far a contact slips that is held too much.
double contact_friction_at(const Team& team, const std::vector<ContactLaw>& laws, double stiffness,
                           const Points& displacement, double time, const Vector& inverse_mass,
                           Index n_cloth, ExtraTerms& terms);

// Slips of the step that has been made, sorted like the contacts; those of pairs that are no
// contacts are dropped. `start`: of the same contacts, as contact_terms() left it.
void update_contact_anchors(const CollisionModel& model, const std::vector<Contact>& contacts,
                            const Points& x0, const Points& x1, const ContactStart& start,
                            ContactState& state);

}  // namespace loomstone
