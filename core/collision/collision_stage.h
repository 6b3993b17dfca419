// Collision handling of one part of a step. Contacts are found at the start of the part. Either an
// implicit solve includes them as extra terms, or impulses correct the motion. Asynchronous steps
// instead evaluate contacts at events, for pairs that approach() finds. Certification then finds
// the impacts of the whole motion by continuous collision detection. It removes them by impulses
// (clean-up) and, if some remain, by withholding motion.
#pragma once

#include <memory>
#include <vector>

#include "core/base/types.h"
#include "core/collision/approach.h"
#include "core/collision/broad_phase/decomposition.h"
#include "core/collision/certify/certify_report.h"
#include "core/collision/collision_replay.h"
#include "core/collision/model/collision_model.h"
#include "core/collision/model/contact.h"
#include "core/collision/model/free_body.h"
#include "core/collision/response/contact_terms.h"
#include "core/collision/response/found_contacts.h"
#include "core/collision/response/response_inputs.h"
#include "core/collision/tangle/tangle.h"
#include "core/linalg/extra_terms.h"
#include "core/parallel/communicator.h"
#include "core/parallel/team.h"

namespace loomstone {

// Collision stage of a simulation. Caches trees, neighbour lists and contacts between calls. The
// caches affect speed, not results. The ranks divide the searches for contacts and impacts among
// themselves. Each rank receives all impacts and, unless divide() has been called, all contacts.
// With the decomposition "predicted", each rank tests the pairs in its part of the neighbour lists
// and searches its share of the surface pairs without lists. With the other decompositions, the
// ranks traverse the trees of a SharedSearch or, in approach(), of BroadPhase.
class CollisionStage {
 public:
  // All decompositions give the same results.
  explicit CollisionStage(const CollisionModel& model,
                          Decomposition decomposition = Decomposition::Predicted,
                          std::shared_ptr<const Communicator> communicator = single_communicator());
  ~CollisionStage();

  // All ranks must call this method together. After this call, each rank keeps only the contacts
  // that act on its `rows` and those that influence the shares (contact_shares()) of such contacts.
  // The rank of row 0 also keeps contacts that act on no row; see ContactSelection. proximity()
  // then returns only kept contacts.
  void divide(IndexRange rows);
  bool divided() const;

  // Finds the intersections at x0 of surfaces that must not intersect; see kept_apart(). Methods
  // that receive this Tangle ignore contacts and impacts that would prevent the intersecting
  // surfaces from separating. The Tangle is empty if there are no intersections.
  Tangle find_tangle(const Points& x0);

  // Collective. Returns the contacts at x0, sorted by (kind, a, b), except those that `tangle`
  // ignores. A contact is closer than its thickness. Two edges have a contact only if their closest
  // points lie inside both edges. For smooth surfaces, see CollisionSurface::smooth. x0 contains
  // the vertices of all surfaces. The returned reference is valid until the next call of
  // proximity(), proximity_alone() or all_contacts().
  const std::vector<Contact>& proximity(const Team& team, const Points& x0, const Tangle& tangle);
  // Like proximity(), but returns the contacts of all ranks and is not collective: a rank may call
  // it without the others. Slow if contacts are divided, or if there are several ranks and x0
  // differs from that of the last call of proximity().
  const std::vector<Contact>& proximity_alone(const Team& team, const Points& x0,
                                              const Tangle& tangle);
  // Collective. Returns the contacts of all ranks. Fast if x0 is the same as in the last call of
  // proximity(). Otherwise works like proximity_alone().
  const std::vector<Contact>& all_contacts(const Team& team, const Points& x0,
                                           const Tangle& tangle);
  // Totals, over all ranks, of the contacts that the last call of proximity(), proximity_alone() or
  // all_contacts() found, without those that its `tangle` ignores.
  const ContactTotals& totals() const;

  // Collective. Returns the pairs that may come closer than their thickness in the step of
  // `motion`, except those that `tangle` ignores. At events, asynchronous steps evaluate the
  // contacts of these pairs.
  Approach approach(const Team& team, const ExpectedMotion& motion, const Tangle& tangle);
  const std::vector<SurfacePair>& pairs() const;

  // Appends the contact terms of the implicit solve to `terms`. The returned object updates these
  // terms during the solve. `contacts` must be the result of proximity() at inputs.x0, or some of
  // these contacts.
  ContactTerms terms(const Team& team, const ContactInputs& inputs,
                     const std::vector<Contact>& contacts, const ContactState& state,
                     ExtraTerms& terms) const;

  // Returns contact_energies() [J] for `motion`, whose end must be StrengthInputs::x. `contacts`
  // must be the result of proximity() or proximity_alone() at this end. `rows` are the rows of this
  // rank if contacts are divided and come from proximity(), otherwise all rows.
  std::vector<BinnedSum> energies(const ContactMotion& motion, const StrengthInputs& inputs,
                                  const std::vector<Contact>& contacts, IndexRange rows) const;

  // Appends terms that move intersecting surfaces apart; see response/untangling.h.
  void untangle(const ContactInputs& inputs, const Tangle& tangle, ExtraTerms& terms) const;

  // Collective if contacts are divided. Updates the friction anchors of all contacts after the
  // motion x0 -> x1. `made` must be the terms that terms() returned for `contacts`. Returns the
  // energy [J] at x0 of the normal forces and friction anchors of all contacts. If contacts are
  // divided, it is the sum of ContactTerms::energy() over the ranks.
  double update_anchors(const std::vector<Contact>& contacts, const ContactTerms& made,
                        const Points& x0, const Points& x1, ContactState& state) const;

  // Responds to contacts by impulses, which correct the end positions of cloth and bodies. Features
  // in contact stop approaching, gradually regain almost their thickness and are subject to
  // friction. Intersecting surfaces are moved apart; see response/untangling.h.
  void repel(const MotionInputs& inputs, const std::vector<Contact>& contacts, double step,
             Points& x1, FreeBodies& bodies) const;

  // Collective. Corrects x1, and the end poses of `bodies`, so that the motion x0 -> x1 has no
  // impact (see ImpactSearch::find()) and x1 has no new intersection, unless
  // CertifyReport::unresolved is positive. Moves cloth vertices individually and each body as a
  // whole. Prescribed vertices and obstacles keep their motion. If `bodies` is empty, rigid bodies
  // also keep their motion.
  CertifyReport certify(const Team& team, const MotionInputs& inputs, Points& x1,
                        FreeBodies& bodies);

  // Memory of the bounding-volume hierarchies on this rank, except those that only
  // proximity_alone() uses [bytes].
  std::size_t hierarchy_bytes() const;
  // Memory of lists, of the hierarchies of proximity_alone() and of other search data [bytes].
  std::size_t list_bytes() const;
  // Memory of contacts and of data that belongs to them, without motion() [bytes].
  std::size_t contact_bytes() const;

  // Sets whether certify() stores the motion that it receives, and the starts of preceding motions
  // that it received since keep_motion(true). Motions with the same start count as one.
  // keep_motion(false) discards what is stored.
  void keep_motion(bool keep);
  // Returns the last motion that certify() stored, or a motion without vertices if there is none.
  CollisionRecord motion() const;
  std::size_t motion_bytes() const;  // memory of the positions that certify() has stored [bytes]

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace loomstone
