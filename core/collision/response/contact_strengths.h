// Quantities on which contact forces depend and that a Contact does not contain: shares, stiffness,
// and slips of friction anchors.
#pragma once

#include <vector>

#include "core/base/bytes.h"
#include "core/base/types.h"
#include "core/collision/model/collision_model.h"
#include "core/collision/model/contact.h"

namespace loomstone {

// Each vector has one entry for each contact.
struct ContactStrengths {
  std::vector<double> shares;     // see contact_shares() [1]
  std::vector<double> stiffness;  // see contact_stiffness() [N/m]
  std::vector<Vec3> slips;        // see anchored_slips() [m]

  std::size_t bytes() const { return bytes_of(shares, stiffness, slips); }
};

// Inputs of the strengths of contacts at x, for n collision vertices.
struct StrengthInputs {
  const Points& x;             // (n x 3) [m]
  const Vector& inverse_mass;  // (n) inverse masses of free cloth vertices, else 0 [1/kg]
  const Points& forces;        // (cloth vertices x 3) see contact_stiffness() [N]
  const ContactState& anchors;
};

ContactStrengths contact_strengths(const CollisionModel& model,
                                   const std::vector<Contact>& contacts,
                                   const StrengthInputs& inputs);

// Strengths of contacts whose positions and masses stay the same, while forces and anchors change.
// Shares and slips that are still valid are not computed again.
class KnownStrengths {
 public:
  // Returns contact_strengths() of the arguments. Between two calls of forget(), all calls of
  // find() must have the same contacts, positions and masses.
  const ContactStrengths& find(const CollisionModel& model, const std::vector<Contact>& contacts,
                               const StrengthInputs& inputs);
  void forget() { known_at_x_ = false; }
  std::size_t bytes() const { return bytes_of(known_, anchors_); }

 private:
  bool known_at_x_ = false;
  ContactStrengths known_;
  // Anchors from which the slips in known_ were computed.
  std::vector<ContactState::Anchor> anchors_;
};

}  // namespace loomstone
