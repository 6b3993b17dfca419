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
#include "core/linalg/extra_terms.h"
#include "core/parallel/team.h"

namespace loomstone {

class CollisionStage {
 public:
  // `rest`: positions in which non-adjacent primitives of one surface may already be closer than
  // the thickness.
  CollisionStage(const CollisionModel& model);
  ~CollisionStage();

  // Finds what intersects at x0, which then moves apart: contacts that would hold it there and
  // impacts on its way out are left out until the next call. Returns the number of edges that
  // pierce triangles. A stage begins with nothing tangled.
  std::int64_t find_tangle(const Points& x0);
  void forget_tangle();

  // Contacts closer than their thickness at x0 (all vertices), sorted by (kind, a, b).
  std::vector<Contact> proximity(const Team& team, const Points& x0);

  // Terms for the implicit solve (notes/response.md 1-2): x0, v0 of all vertices, h, anchors in;
  // velocities of scripted vertices go into the drift. `body_centres` (b x 3). Penalty energy
  // summed into `energy`. `last_change` (n): of velocities in the last step, 0 where unknown.
  void terms(const std::vector<Contact>& contacts, const Points& x0, const Points& v0,
             const Points& last_change, const Points& body_centres, double step, Index n_cloth,
             const ContactState& state, ExtraTerms& terms, double& energy);

  // Terms that move what is tangled along its way out, in proportion to displacements.
  void untangle(const Points& x0, const Points& v0, const Points& body_centres, double step,
                Index n_cloth, ExtraTerms& terms);

  // The terms that terms() made last, where rows have moved by `displacement` (rows x 3) [m] in
  // `time` [s]; they come first in `terms`. Pairs, weights, normals and anchors are those of the
  // start. Returns their energy [J].
  double terms_at(const Team& team, const Points& displacement, double time, TermRequest request,
                  ExtraTerms& terms);

  // The terms that terms() made last, with the friction that belongs to where rows have moved; see
  // contact_terms.h.
  double friction_at(const Team& team, const Points& displacement, double time,
                     const Vector& inverse_mass, Index n_cloth, ExtraTerms& terms);

  // Anchors after the step, from the actual motion x0 -> x1; terms() has been asked for those of
  // these contacts.
  void update_anchors(const std::vector<Contact>& contacts, const Points& x0, const Points& x1,
                      ContactState& state);

  // The response by impulses: changes the ends of cloth and bodies so that contacts of x0 approach
  // no further, regain their thickness softly and rub, and what is tangled moves apart.
  // `inverse_mass` (n): of cloth, 0 for what must not move.
  void repel(const std::vector<Contact>& contacts, const Points& x0, Points& x1,
             const Vector& inverse_mass, double step, FreeBodies& bodies);

  // Corrects x1 (cloth vertices, and `bodies` as a whole; scripts, and bodies if none are given,
  // are as they are) so that the motion x0 -> x1 has no impact and ends without intersection.
  // `inverse_mass` (n): of cloth, 0 for what must not move.
  CertifyReport certify(const Team& team, const Points& x0, Points& x1, const Vector& inverse_mass,
                        FreeBodies& bodies);

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace loomstone
