// Contacts with friction as terms of the implicit solve: two-stage repulsion along the normal, anchored springs across it.
#pragma once

#include "core/collision/collision_stage.h"

namespace loomstone {

void contact_terms(const CollisionModel& model, const std::vector<Contact>& contacts, const Points& x0, const Points& v0,
                   const Points& last_change, const Points& body_centres, double step, Index n_cloth, const ContactState& state, ExtraTerms& terms,
                   double& energy);

// Slips of the step that has been made, sorted like the contacts; those of pairs that are no contacts are dropped.
void update_contact_anchors(const CollisionModel& model, const std::vector<Contact>& contacts, const Points& x0,
                            const Points& x1, ContactState& state);

}  // namespace loomstone
