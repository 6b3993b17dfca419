// The collision stages of a step: contacts near the start, as terms of the implicit solve or
// answered by impulses after an explicit one; and certification of the whole motion at the end
// (continuous collision detection, clean-up by impulses, withheld motion).
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

// Stage. It keeps trees and neighbour lists between calls; this affects only speed, never results.
class CollisionStage {
 public:
  explicit CollisionStage(const CollisionModel& model);
  ~CollisionStage();

  // Everything that intersects at x0. Given to the other methods, contacts and impacts that would
  // keep it entangled are ignored. Tangle{}: nothing intersects.
  Tangle find_tangle(const Points& x0);

  // Contacts closer than their thickness at x0 (all vertices), sorted by (kind, a, b).
  std::vector<Contact> proximity(const Team& team, const Points& x0, const Tangle& tangle);

  // Appends contact terms of the implicit solve to `terms`. Returns what updates them during the
  // solve.
  ContactTerms terms(const ContactInputs& inputs, const std::vector<Contact>& contacts,
                     const ContactState& state, ExtraTerms& terms) const;

  // Appends terms that move intersecting features along their way out.
  void untangle(const ContactInputs& inputs, const Tangle& tangle, ExtraTerms& terms) const;

  // Sets the friction anchors after the motion x0 -> x1; `made` are the terms of `contacts`.
  void update_anchors(const std::vector<Contact>& contacts, const ContactTerms& made,
                      const Points& x0, const Points& x1, ContactState& state) const;

  // Response by impulses: corrects the ends of cloth and bodies so that contacts of x0 stop
  // approaching, regain their thickness gradually and rub, and intersections resolve.
  void repel(const MotionInputs& inputs, const std::vector<Contact>& contacts, double step,
             Points& x1, FreeBodies& bodies) const;

  // Corrects x1 so that the motion x0 -> x1 has no impact and ends without intersections. Moves
  // cloth vertices and `bodies` as a whole; prescribed vertices keep their motion, and so do bodies
  // if `bodies` is empty.
  CertifyReport certify(const Team& team, const MotionInputs& inputs, Points& x1,
                        FreeBodies& bodies);

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace loomstone
