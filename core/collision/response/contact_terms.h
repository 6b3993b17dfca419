// Contacts with friction as terms of the implicit solve. Each contact has a repulsion along its
// normal and an anchored tangential spring (docs/method.md, "Contact terms" and "Friction").
#pragma once

#include <array>

#include "core/base/bytes.h"
#include "core/collision/model/collision_model.h"
#include "core/collision/model/contact.h"
#include "core/collision/response/contact_strengths.h"
#include "core/collision/response/response_inputs.h"
#include "core/linalg/extra_terms.h"
#include "core/parallel/binned_sum.h"
#include "core/parallel/team.h"

namespace loomstone {

// Data of one contact that its ExtraTerm does not contain. The feature pair, weights, normal and
// anchor of a contact are constant during a step. The gap is measured along the constant normal.
struct ContactLaw {
  Vec3 normal;
  double distance, thickness;  // distance at the start, thickness [m]
  double share, friction;      // share (see contact_shares()), friction coefficient [1]
  Vec3 slip;                   // anchor slip at the start [m]
  double limit;                // largest friction force: mu times normal force times share [N]
  double normal_stiffness;     // stiffness in the normal direction times the share [N/m]
  double steepest;             // largest allowed slope of the normal force [N/m]
  double parting;              // predicted rate of change of the distance [m/s]
  Index contact;               // index in the list of contacts from which the terms were made
  // True if the sums of this rank include the term; see ContactTerms::counts().
  bool counts;
};

// Error of the forces in contact terms, compared with the forces that contact and friction exert
// after a motion; see ContactTerms::forces_after(). Errors of several ranks can be added in any
// order.
struct ContactError {
  enum { Wrong, Excess, Limit, Pull, Push, Closing, n_sums };
  // Sums over contacts: magnitude of the error of friction [N], component of this error along
  // the slip of the step (positive if friction took too much energy) [N], friction limit [N],
  // normal forces that pull [N], normal forces that push [N], and number of contacts that would
  // close (see `closing` in contact_terms.cpp).
  std::array<BinnedSum, n_sums> sums;

  // Returns 1 if any contact would close. Otherwise returns the largest of these ratios [1]: the
  // error of friction divided by the friction limit, half the forces that pull divided by those
  // that push and, with `limit_excess`, ten times the excess divided by the friction limit. A ratio
  // whose numerator is not positive counts as 0.
  double relative(bool limit_excess) const;
};

// Contact terms of one step, in the order of the contacts. They must be the first terms in the
// solve.
class ContactTerms {
 public:
  ContactTerms() = default;
  // Appends a term for each contact that has a positive share and acts on at least one of
  // `inputs.rows`. `contacts` may omit contacts that act on other rows only.
  ContactTerms(const Team& team, const CollisionModel& model, const ContactInputs& inputs,
               const std::vector<Contact>& contacts, const ContactStrengths& strengths,
               ExtraTerms& terms);

  std::size_t size() const { return laws_.size(); }  // number of terms
  // Number of contacts that count on this rank, have a positive share and act on at least one
  // row of any rank. The sum over the ranks is the number of all terms, each counted once.
  std::int64_t n_counted() const { return n_counted_; }
  Index contact(std::size_t term) const { return laws_[term].contact; }
  // Returns whether the first row of a term is one of `inputs.rows`. If each row belongs to
  // `inputs.rows` of one rank only, each term counts on one rank.
  bool counts(std::size_t term) const { return laws_[term].counts; }
  std::size_t bytes() const { return bytes_of(laws_, shares_, slips_, forces_, counted_); }
  Vec3 normal(std::size_t term) const { return laws_[term].normal; }
  // Energy of normal forces and anchors at the start, for the contacts of n_counted() [J].
  const BinnedSum& energy() const { return energy_; }

  // Updates the first size() entries of `terms` to the normal and friction forces after the rows
  // have moved by `displacement` (rows x 3) [m, rad] in `time` [s]. Returns the energy of these
  // forces [J]. For constant friction limits, the forces derive from this energy.
  // TermRequest::NewLimits recomputes the limits. TermRequest::Secant sets `secant` of
  // friction_at().
  double at(const Team& team, const Points& displacement, double time, TermRequest request,
            ExtraTerms& terms);

  // Linearises the terms again about the start of the step. The normal force that is expected after
  // `displacement` gives the friction limit. The slip after `displacement` gives the friction force
  // and its secant stiffness. If a contact would close, its normal stiffness is also a secant
  // stiffness. If a contact has pulled, its normal stiffness is the secant stiffness up to the
  // larger of two gaps: that after `displacement` and that after the predicted motion. With
  // `keep_normal`, normal forces change only in contacts that have pulled, and these contacts have
  // no friction. Returns the sums of ContactError over terms that count. The error refers to the
  // forces that `terms` had before the call. `inverse_mass` of cloth rows [1/kg] is used to predict
  // the slip of contacts whose friction was too large.
  ContactError forces_after(const Team& team, const Points& displacement, double time,
                            const Vector& inverse_mass, bool keep_normal, ExtraTerms& terms) const;

  // Returns the friction anchors after the motion x0 -> x1, one for each contact that counts on
  // this rank. `contacts` must be those passed to the constructor.
  std::vector<ContactState::Anchor> anchors(const CollisionModel& model,
                                            const std::vector<Contact>& contacts, const Points& x0,
                                            const Points& x1) const;

 private:
  std::vector<ContactLaw> laws_;  // one for each term
  std::vector<Index> counted_;    // indices of contacts that count on this rank, in ascending order
  std::vector<double> shares_;    // share of each contact [1]
  std::vector<Vec3> slips_;       // anchor slip of each contact at the start [m]
  std::vector<double> forces_;    // normal forces at the start, not multiplied by the shares [N]
  double tangential_ = 0.0;       // stiffness of the anchor of a contact with share 1 [N/m]
  Index n_cloth_ = 0;
  std::int64_t n_counted_ = 0;
  BinnedSum energy_;
};

// Motion of n collision vertices.
struct ContactMotion {
  const Points& x;   // (n x 3) end of the motion [m]
  const Points& x0;  // (n x 3) start of the motion [m]; unused if n_parts is 1
  int n_parts = 1;   // number of equal parts of the motion
};

// Returns the energy of normal forces and friction anchors at the end of each part of the motion,
// for the contacts that count for `rows` (see ActingOn) [J]. The energies of all parts but the last
// are estimates. They assume that distances and slips change linearly and that slips are zero at
// the start.
std::vector<BinnedSum> contact_energies(const CollisionModel& model, const ContactMotion& motion,
                                        const std::vector<Contact>& contacts,
                                        const ContactStrengths& strengths, IndexRange rows);

}  // namespace loomstone
