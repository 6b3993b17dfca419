#include "core/collision/response/contact_strengths.h"

#include "core/base/same_bits.h"
#include "core/collision/response/contacts.h"
#include "core/collision/response/friction.h"

namespace loomstone {

ContactStrengths contact_strengths(const CollisionModel& model,
                                   const std::vector<Contact>& contacts,
                                   const StrengthInputs& inputs) {
  return {contact_shares(contacts, model, inputs.x),
          contact_stiffness(contacts, model, inputs.inverse_mass, inputs.forces),
          anchored_slips(contacts, model, inputs.anchors)};
}

const ContactStrengths& KnownStrengths::find(const CollisionModel& model,
                                             const std::vector<Contact>& contacts,
                                             const StrengthInputs& inputs) {
  if (!known_at_x_) known_.shares = contact_shares(contacts, model, inputs.x);
  known_.stiffness = contact_stiffness(contacts, model, inputs.inverse_mass, inputs.forces);
  if (!known_at_x_ || inputs.anchors.anchors != anchors_) {
    known_.slips = anchored_slips(contacts, model, inputs.anchors);
    anchors_ = inputs.anchors.anchors;
  }
  known_at_x_ = true;
  return known_;
}

}  // namespace loomstone
