// The places of a step where collisions act: near contacts before the integrator (as terms of its
// implicit solve, or answered by impulses after it), and certification after everything has moved
// (continuous test, clean-up by impulses, truncation).
#pragma once

#include <memory>
#include <vector>

#include "core/base/types.h"
#include "core/collision/certify/certify_report.h"
#include "core/collision/model/collision_model.h"
#include "core/collision/model/contact.h"
#include "core/collision/model/free_body.h"
#include "core/collision/response/contact_terms.h"
#include "core/collision/response/response_inputs.h"
#include "core/collision/tangle/tangle.h"
#include "core/linalg/extra_terms.h"
#include "core/parallel/team.h"

namespace loomstone {

// Stage: keeps trees and neighbour lists between calls, which changes speed and no result.
class CollisionStage {
 public:
  explicit CollisionStage(const CollisionModel& model);
  ~CollisionStage();

  // What intersects at x0, which then moves apart: contacts that would hold it there and impacts on
  // its way out are left out by all that takes the tangle. Tangle{}: nothing intersects.
  Tangle find_tangle(const Points& x0);

  // Contacts closer than their thickness at x0 (all vertices), sorted by (kind, a, b).
  std::vector<Contact> proximity(const Team& team, const Points& x0, const Tangle& tangle);

  // Terms for the implicit solve, appended to `terms`; what is returned moves them.
  ContactTerms terms(const ContactInputs& inputs, const std::vector<Contact>& contacts,
                     const ContactState& state, ExtraTerms& terms) const;

  // Terms that move what is tangled along its way out, in proportion to displacements.
  void untangle(const ContactInputs& inputs, const Tangle& tangle, ExtraTerms& terms) const;

  // Anchors after the step, from the actual motion x0 -> x1; `made` are the terms of `contacts`.
  void update_anchors(const std::vector<Contact>& contacts, const ContactTerms& made,
                      const Points& x0, const Points& x1, ContactState& state) const;

  // The response by impulses: changes the ends of cloth and bodies so that contacts of x0 approach
  // no further, regain their thickness softly and rub, and what is tangled moves apart.
  void repel(const MotionInputs& inputs, const std::vector<Contact>& contacts, double step,
             Points& x1, FreeBodies& bodies) const;

  // Corrects x1 (cloth vertices, and `bodies` as a whole; scripts, and bodies if none are given,
  // are as they are) so that the motion x0 -> x1 has no impact and ends without intersection.
  CertifyReport certify(const Team& team, const MotionInputs& inputs, Points& x1,
                        FreeBodies& bodies);

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace loomstone
