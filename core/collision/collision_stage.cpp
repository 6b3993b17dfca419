#include "core/collision/collision_stage.h"

#include <algorithm>
#include <utility>

#include "core/base/same_bits.h"
#include "core/collision/certify/clean_up.h"
#include "core/collision/certify/withholding.h"
#include "core/collision/response/contact_terms.h"
#include "core/collision/response/contacts.h"
#include "core/collision/response/repulsion.h"
#include "core/collision/response/untangling.h"

namespace loomstone {

// Maximum number of clean-up rounds before motion is withheld. Three suffice if the cloth has room
// to move. Plates whose gap closed to a twentieth of the thickness in one step needed up to ten.
constexpr int clean_up_rounds = 10;

struct CollisionStage::Data {
  Data(const CollisionModel& given, Decomposition decomposition,
       std::shared_ptr<const Communicator> shared_by)
      : model(given),
        communicator(std::move(shared_by)),
        ranks(*communicator),
        pairs(surface_pairs(model)),
        broad_phase(model, pairs, {ranks.rank(), ranks.size()}),
        lists(model, pairs, broad_phase, ranks),
        tangles(model),
        search(model, broad_phase, lists),
        approaches(model, pairs, broad_phase, lists) {
    if (decomposition != Decomposition::Predicted)
      shared =
          std::make_unique<SharedSearch>(model, pairs, broad_phase, decomposition, communicator);
    search.share(shared.get());
  }

  bool knows(const Points& x) const { return same_bits(known_x, x); }

  // Calls use(strengths) with the strengths of contacts that proximity() has found.
  template <class Use>
  auto with_strengths(const std::vector<Contact>& contacts, const StrengthInputs& inputs,
                      Use&& use) {
    // If contacts are ignored because of a tangle, the shares of the remaining contacts change.
    if (contacts.size() == known.size() && knows(inputs.x))
      return use(strengths.find(model, contacts, inputs));
    return use(contact_strengths(model, contacts, inputs));
  }

  const CollisionModel& model;
  const std::shared_ptr<const Communicator> communicator;
  const Communicator& ranks;
  const std::vector<SurfacePair> pairs;
  BroadPhase broad_phase;
  NeighbourLists lists;
  TangleFinder tangles;
  ImpactSearch search;
  ApproachSearch approaches;
  SmoothNormals normals;
  std::unique_ptr<SharedSearch> shared;  // null: searches use the lists
  bool keeps_motion = false;
  CollisionRecord motion;
  std::unique_ptr<BroadPhase> own_broad_phase;  // performs all ranks' tasks; made at first use
  // Positions x0 of the last call of proximity(), and the contacts at x0. A part of a step begins
  // where the preceding one ended, so contacts found there are used again. `known` also contains
  // the contacts that proximity() omits because of a tangle. Both members are the same on all
  // ranks.
  Points known_x;
  std::vector<Contact> known;
  KnownStrengths strengths;       // of the contacts in `known`
  std::vector<Contact> returned;  // result of the last call, if it differs from `known`

  std::vector<Contact> without_ignored(const std::vector<Contact>& contacts,
                                       const Tangle& tangle) const {
    std::vector<Contact> kept;
    for (const Contact& contact : contacts)
      if (!tangle.ignores(model, contact.kind, pair_key(contact.a, contact.b), contact.vertices))
        kept.push_back(contact);
    return kept;
  }
};

CollisionStage::CollisionStage(const CollisionModel& model, Decomposition decomposition,
                               std::shared_ptr<const Communicator> communicator)
    : data_(std::make_unique<Data>(model, decomposition, std::move(communicator))) {}
CollisionStage::~CollisionStage() = default;

Tangle CollisionStage::find_tangle(const Points& x0) { return data_->tangles.find(x0); }

const std::vector<Contact>& CollisionStage::proximity(const Team& team, const Points& x0,
                                                      const Tangle& tangle) {
  Data& d = *data_;
  if (!d.knows(x0)) {
    if (d.shared) {
      d.known = find_contacts(team, d.model, d.pairs, x0, *d.shared, d.normals);
    } else {
      d.lists.begin_update(team, x0);
      d.known = find_contacts(team, d.model, d.pairs, x0, d.lists, d.normals);
    }
    d.known_x = x0;
    d.strengths.forget();
  }
  if (tangle.empty()) return d.known;
  d.returned = d.without_ignored(d.known, tangle);
  return d.returned;
}

const std::vector<Contact>& CollisionStage::proximity_alone(const Team& team, const Points& x0,
                                                            const Tangle& tangle) {
  Data& d = *data_;
  if (d.ranks.size() == 1 || d.knows(x0)) return proximity(team, x0, tangle);
  if (!d.own_broad_phase) d.own_broad_phase = std::make_unique<BroadPhase>(d.model, d.pairs);
  d.returned = find_contacts_alone(team, d.model, d.pairs, x0, *d.own_broad_phase, d.normals);
  if (!tangle.empty()) d.returned = d.without_ignored(d.returned, tangle);
  return d.returned;
}

std::size_t CollisionStage::hierarchy_bytes() const {
  return data_->broad_phase.bytes() + (data_->shared ? data_->shared->hierarchy_bytes() : 0);
}

std::size_t CollisionStage::list_bytes() const {
  const Data& d = *data_;
  return d.lists.bytes() + d.search.bytes() + d.tangles.bytes() +
         (d.own_broad_phase ? d.own_broad_phase->bytes() : 0);
}

std::size_t CollisionStage::contact_bytes() const {
  return bytes_of(data_->known_x, data_->known, data_->returned, data_->strengths, data_->normals);
}

void CollisionStage::keep_motion(bool keep) { data_->keeps_motion = keep; }
const CollisionRecord& CollisionStage::motion() const { return data_->motion; }

Approach CollisionStage::approach(const Team& team, const ExpectedMotion& motion,
                                  const Tangle& tangle) {
  return data_->approaches.find(team, motion, tangle, !data_->shared);
}

const std::vector<SurfacePair>& CollisionStage::pairs() const { return data_->pairs; }

ContactTerms CollisionStage::terms(const ContactInputs& inputs,
                                   const std::vector<Contact>& contacts, const ContactState& state,
                                   ExtraTerms& terms) const {
  const StrengthInputs at_start{inputs.x0, inputs.inverse_mass, inputs.forces, state};
  return data_->with_strengths(contacts, at_start, [&](const ContactStrengths& strengths) {
    return ContactTerms(data_->model, inputs, contacts, strengths, terms);
  });
}

std::vector<double> CollisionStage::energies(const ContactMotion& motion,
                                             const StrengthInputs& inputs,
                                             const std::vector<Contact>& contacts) const {
  return data_->with_strengths(contacts, inputs, [&](const ContactStrengths& strengths) {
    return contact_energies(data_->model, motion, contacts, strengths);
  });
}

void CollisionStage::untangle(const ContactInputs& inputs, const Tangle& tangle,
                              ExtraTerms& terms) const {
  untangling_terms(data_->model, tangle, inputs, terms);
}

void CollisionStage::update_anchors(const std::vector<Contact>& contacts, const ContactTerms& made,
                                    const Points& x0, const Points& x1, ContactState& state) const {
  state.anchors = made.anchors(data_->model, contacts, x0, x1);
}

void CollisionStage::repel(const MotionInputs& inputs, const std::vector<Contact>& contacts,
                           double step, Points& x1, FreeBodies& bodies) const {
  loomstone::repel(data_->model, inputs, contacts, step, x1, bodies);
}

CertifyReport CollisionStage::certify(const Team& team, const MotionInputs& inputs, Points& x1,
                                      FreeBodies& bodies) {
  if (data_->keeps_motion) {
    const CollisionModel& model = data_->model;
    data_->motion = {model.surfaces, model.triangles, model.gap_floor, inputs.x0, x1};
  }
  Vector inverse_mass = inputs.inverse_mass;
  for (const CollisionSurface& surface : data_->model.surfaces)
    if (surface.kind != CollisionSurface::Kind::Cloth)
      inverse_mass.segment(surface.first_vertex, surface.n_vertices)
          .setConstant(surface.body >= 0 && !bodies.empty() ? bodies[surface.body].inverse_mass
                                                            : 0.0);
  const MotionInputs all{inputs.x0, inverse_mass, inputs.tangle};
  std::vector<StepImpact> impacts = data_->search.find(team, all, x1, nullptr);
  const std::int64_t n_impacts = static_cast<std::int64_t>(impacts.size());
  if (n_impacts == 0) return {};

  CleanUp clean_up(data_->model, data_->pairs, inverse_mass, bodies);
  for (int round = 0; round < clean_up_rounds && !impacts.empty(); ++round) {
    clean_up.solve(impacts, inputs.x0, x1);
    impacts = data_->search.find(team, all, x1, nullptr);
  }
  CertifyReport report = withhold_motion(team, data_->search, all, std::move(impacts), x1, bodies);
  report.impacts = n_impacts;
  return report;
}

}  // namespace loomstone
