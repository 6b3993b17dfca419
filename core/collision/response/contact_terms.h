// Contacts with friction as terms of the implicit solve. Each contact has a repulsion along
// its normal and an anchored tangential spring (method.md, Contact terms and Friction).
#pragma once

#include "core/base/bytes.h"
#include "core/collision/model/collision_model.h"
#include "core/collision/model/contact.h"
#include "core/collision/response/contact_strengths.h"
#include "core/collision/response/response_inputs.h"
#include "core/linalg/extra_terms.h"
#include "core/parallel/team.h"

namespace loomstone {

// Data of one contact that its ExtraTerm does not contain. Pairs, weights, normals and anchors are
// constant during a step. The gap is measured along the constant normal.
struct ContactLaw {
  Vec3 normal;
  double distance, thickness;  // distance at the start, thickness [m]
  double share, friction;      // share (see contact_shares()), friction coefficient [1]
  Vec3 slip;                   // anchor slip at the start [m]
  double limit;                // largest friction force, mu N [N]
  double normal_stiffness;     // stiffness in the normal direction times the share [N/m]
  double steepest;             // largest slope of the normal force [N/m]
};

// Contact terms of one step, in the order of the contacts. They must be the first terms in the
// solve.
class ContactTerms {
 public:
  ContactTerms() = default;
  // Appends a term for each contact that has a positive share and acts on at least one row.
  ContactTerms(const CollisionModel& model, const ContactInputs& inputs,
               const std::vector<Contact>& contacts, const ContactStrengths& strengths,
               ExtraTerms& terms);

  std::size_t size() const { return laws_.size(); }
  std::size_t bytes() const { return bytes_of(laws_, shares_, slips_, forces_); }
  Vec3 normal(std::size_t term) const { return laws_[term].normal; }
  double energy() const { return energy_; }  // energy of normal forces and anchors at the start [J]

  // Updates the first size() entries of `terms` to the normal and friction forces after the rows
  // have moved by `displacement` (rows x 3) [m] in `time` [s]. Returns the energy of these forces
  // [J]. For constant friction limits, the forces derive from this energy. TermRequest::NewLimits
  // recomputes the limits.
  double at(const Team& team, const Points& displacement, double time, TermRequest request,
            ExtraTerms& terms);

  // Linearises the terms again about the start of the step. The normal force after `displacement`
  // gives the friction limit. The slip after `displacement` gives the friction force and its secant
  // stiffness. If a contact would close, its normal stiffness is also a secant stiffness. Returns
  // the error that friction had in `terms` before the call, summed over all contacts and divided by
  // the sum of their friction limits [1]. Returns 1 if any contact would close. `inverse_mass` of
  // cloth rows [1/kg] is used to predict the slip of contacts whose friction was too large.
  double friction_at(const Team& team, const Points& displacement, double time,
                     const Vector& inverse_mass, ExtraTerms& terms) const;

  // Returns the friction anchors after the motion x0 -> x1, one for each contact. `contacts` must
  // be those passed to the constructor.
  std::vector<ContactState::Anchor> anchors(const CollisionModel& model,
                                            const std::vector<Contact>& contacts, const Points& x0,
                                            const Points& x1) const;

 private:
  std::vector<ContactLaw> laws_;  // one for each term
  std::vector<double> shares_;    // share of each contact [1]
  std::vector<Vec3> slips_;       // anchor slip of each contact at the start [m]
  std::vector<double> forces_;    // normal force of each contact at the start, for share 1 [N]
  double tangential_ = 0.0;       // stiffness of the anchor of a contact with share 1 [N/m]
  Index n_cloth_ = 0;
  double energy_ = 0.0;
};

// Motion of n collision vertices.
struct ContactMotion {
  const Points& x;   // (n x 3) end of the motion [m]
  const Points& x0;  // (n x 3) start of the motion, unused if it has one part [m]
  int n_parts = 1;   // number of equal parts of the motion
};

// Returns the energy of the normal forces and of the friction anchors of contacts at the end of
// each part of the motion [J]. The energies of all parts but the last are estimates. They assume
// that distances change linearly and that the anchors have no slip at the start.
std::vector<double> contact_energies(const CollisionModel& model, const ContactMotion& motion,
                                     const std::vector<Contact>& contacts,
                                     const ContactStrengths& strengths);

}  // namespace loomstone
