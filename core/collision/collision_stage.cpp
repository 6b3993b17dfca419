#include "core/collision/collision_stage.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "core/base/same_bits.h"
#include "core/collision/certify/clean_up.h"
#include "core/collision/certify/withholding.h"
#include "core/collision/response/contact_terms.h"
#include "core/collision/response/contacts.h"
#include "core/collision/response/repulsion.h"
#include "core/collision/response/term_entries.h"
#include "core/collision/response/untangling.h"
#include "core/parallel/merge_runs.h"

namespace loomstone {

// Maximum number of clean-up rounds before motion is withheld. Our choice.
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

  bool knows(const Points& x) const {
    return shared ? same_bits(known_x, x)
                  : known_update == lists.n_updates() && lists.updated_at(x);
  }

  // Calls use(strengths) with the ContactStrengths of `contacts`.
  template <class Use>
  auto with_strengths(const std::vector<Contact>& contacts, const StrengthInputs& inputs,
                      Use&& use) {
    // The stored strengths are those of all known contacts. If some of these contacts are ignored
    // because of a tangle, the shares (contact_shares()) of the remaining contacts change.
    if (contacts.size() == known.contacts.size() && knows(inputs.x))
      return use(strengths.find(model, contacts, inputs));
    return use(contact_strengths(model, contacts, inputs));
  }

  ContactSearch contact_search() {
    return {model, pairs, normals, selection ? &*selection : nullptr};
  }

  // Returns whether all ranks know the contacts at x. Collective.
  bool all_know(const Points& x) const {
    const std::vector<char> known_on = results_of_ranks(ranks, [&]() -> char { return knows(x); });
    return std::all_of(known_on.begin(), known_on.end(), [](char of_rank) { return of_rank != 0; });
  }

  // Returns those of `contacts` that count on this rank; see ActingOn.
  std::vector<Contact> counted(const std::vector<Contact>& contacts) const {
    std::vector<Contact> own;
    for (const Contact& contact : contacts)
      if (acting_on(model, contact, selection->rows()).counts) own.push_back(contact);
    return own;
  }

  // Returns the totals over the `contacts` of all ranks. Collective if contacts are divided among
  // ranks.
  ContactTotals joined_totals(const std::vector<Contact>& contacts) const {
    if (!selection) return totals_of(model, contacts);
    const ContactTotals own = totals_of(model, counted(contacts));
    struct Numbers {
      std::int64_t n;
      bool pressed, vertex_on_face;
    };
    const std::vector<Numbers> numbers =
        results_of_ranks(ranks, [&] { return Numbers{own.n, own.pressed, own.vertex_on_face}; });
    std::vector<ContactTotals> parts(1);
    parts[0].surfaces = gather_from_ranks(ranks, [&] { return own.surfaces; }).elements;
    for (const Numbers& each : numbers)
      parts.push_back({each.n, each.pressed, each.vertex_on_face, {}});
    return joined(parts);
  }

  void keep(const Points& x0, const Points& x1) {
    if (motion.x0.rows() != 0 && !same_bits(motion.x0, x0)) {
      motion.earlier.push_back(std::move(motion.x0));
      if (motion.earlier.size() > CollisionRecord::most_earlier)
        motion.earlier.erase(motion.earlier.begin());
    }
    motion.x0 = x0;
    motion.x1 = x1;
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
  CollisionRecord motion;  // without surfaces and triangles
  // Used by proximity_alone() to search on this rank alone. Made at first use.
  std::unique_ptr<BroadPhase> own_broad_phase;
  // Contacts at the positions x0 of the last call of proximity(), including contacts that it omits
  // because of a tangle. A part of a step begins where the preceding one ended, so contacts found
  // at the end of a part are used again in the next part. `known` is the same on all ranks if each
  // rank keeps all contacts.
  ContactSet known;
  // These members identify the positions of `known`. With lists, known_update is
  // NeighbourLists::n_updates() after the update at these positions. Without lists, known_x is a
  // copy of them.
  std::int64_t known_update = -1;  // -1: no contacts are known from lists
  Points known_x;
  KnownStrengths strengths;  // strengths of the contacts in `known`
  // Contacts that proximity(), proximity_alone() or all_contacts() returned last, if these are not
  // `known` itself.
  ContactSet returned;
  const ContactTotals* totals = nullptr;      // totals of the contacts returned last
  std::optional<ContactSelection> selection;  // contacts that this rank keeps; nullopt: all
  mutable GatherRoom anchor_room;

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
      d.known = find_contacts(team, d.contact_search(), x0, *d.shared);
      d.known_x = x0;
    } else {
      d.lists.begin_update(team, x0);
      d.known = find_contacts(team, d.contact_search(), x0, d.lists);
      d.known_update = d.lists.n_updates();
    }
    d.strengths.forget();
  }
  d.totals = &d.known.all;
  if (tangle.empty()) return d.known.contacts;
  d.returned.contacts = d.without_ignored(d.known.contacts, tangle);
  d.returned.all = d.joined_totals(d.returned.contacts);
  d.totals = &d.returned.all;
  return d.returned.contacts;
}

const std::vector<Contact>& CollisionStage::proximity_alone(const Team& team, const Points& x0,
                                                            const Tangle& tangle) {
  Data& d = *data_;
  if (!d.selection && (d.ranks.size() == 1 || d.knows(x0))) return proximity(team, x0, tangle);
  if (!d.own_broad_phase) d.own_broad_phase = std::make_unique<BroadPhase>(d.model, d.pairs);
  d.returned = find_contacts_alone(team, {d.model, d.pairs, d.normals}, x0, *d.own_broad_phase);
  if (!tangle.empty()) {
    d.returned.contacts = d.without_ignored(d.returned.contacts, tangle);
    d.returned.all = totals_of(d.model, d.returned.contacts);
  }
  d.totals = &d.returned.all;
  return d.returned.contacts;
}

const std::vector<Contact>& CollisionStage::all_contacts(const Team& team, const Points& x0,
                                                         const Tangle& tangle) {
  Data& d = *data_;
  if (!d.selection || !d.all_know(x0)) return proximity_alone(team, x0, tangle);
  const auto own = [&] {
    return d.counted(tangle.empty() ? d.known.contacts
                                    : d.without_ignored(d.known.contacts, tangle));
  };
  d.returned.contacts = merged(gather_from_ranks(d.ranks, own), place_of_pair);
  d.returned.all = totals_of(d.model, d.returned.contacts);
  d.totals = &d.returned.all;
  return d.returned.contacts;
}

const ContactTotals& CollisionStage::totals() const { return *data_->totals; }

void CollisionStage::divide(IndexRange rows) {
  data_->selection.emplace(data_->model, rows);
  data_->known_update = -1;  // forgets the known contacts
  data_->known_x.resize(0, 3);
}
bool CollisionStage::divided() const { return data_->selection.has_value(); }

std::size_t CollisionStage::hierarchy_bytes() const {
  return data_->broad_phase.bytes() + (data_->shared ? data_->shared->hierarchy_bytes() : 0);
}

std::size_t CollisionStage::list_bytes() const {
  const Data& d = *data_;
  return d.lists.bytes() + d.search.bytes() + d.tangles.bytes() +
         (d.own_broad_phase ? d.own_broad_phase->bytes() : 0);
}

std::size_t CollisionStage::contact_bytes() const {
  const Data& d = *data_;
  return bytes_of(d.known_x, d.known.contacts, d.returned.contacts, d.strengths, d.normals) +
         (d.selection ? d.selection->bytes() : 0);
}

void CollisionStage::keep_motion(bool keep) {
  if (keep != data_->keeps_motion) data_->motion = {};
  data_->keeps_motion = keep;
}

std::size_t CollisionStage::motion_bytes() const {
  const CollisionRecord& motion = data_->motion;
  return bytes_of(motion.x0, motion.x1, motion.earlier);
}

CollisionRecord CollisionStage::motion() const {
  CollisionRecord record = data_->motion;
  if (record.x0.rows() == 0) return record;
  record.surfaces = data_->model.surfaces;
  record.triangles = data_->model.triangles;
  record.gap_floor = data_->model.gap_floor;
  return record;
}

Approach CollisionStage::approach(const Team& team, const ExpectedMotion& motion,
                                  const Tangle& tangle) {
  return data_->approaches.find(team, motion, tangle, !data_->shared);
}

const std::vector<SurfacePair>& CollisionStage::pairs() const { return data_->pairs; }

ContactTerms CollisionStage::terms(const Team& team, const ContactInputs& inputs,
                                   const std::vector<Contact>& contacts, const ContactState& state,
                                   ExtraTerms& terms) const {
  const StrengthInputs at_start{inputs.x0, inputs.inverse_mass, inputs.forces, state};
  return data_->with_strengths(contacts, at_start, [&](const ContactStrengths& strengths) {
    return ContactTerms(team, data_->model, inputs, contacts, strengths, terms);
  });
}

std::vector<BinnedSum> CollisionStage::energies(const ContactMotion& motion,
                                                const StrengthInputs& inputs,
                                                const std::vector<Contact>& contacts,
                                                IndexRange rows) const {
  return data_->with_strengths(contacts, inputs, [&](const ContactStrengths& strengths) {
    return contact_energies(data_->model, motion, contacts, strengths, rows);
  });
}

void CollisionStage::untangle(const ContactInputs& inputs, const Tangle& tangle,
                              ExtraTerms& terms) const {
  untangling_terms(data_->model, tangle, inputs, terms);
}

double CollisionStage::update_anchors(const std::vector<Contact>& contacts,
                                      const ContactTerms& made, const Points& x0, const Points& x1,
                                      ContactState& state) const {
  const Data& d = *data_;
  if (!d.selection) {
    state.anchors = made.anchors(d.model, contacts, x0, x1);
    return made.energy().value();
  }
  using Anchor = ContactState::Anchor;
  auto all = gather_again<Anchor, BinnedSum>(d.ranks, d.anchor_room, [&](BinnedSum& energy) {
    energy = made.energy();
    return made.anchors(d.model, contacts, x0, x1);
  });
  state.anchors = merged(std::move(all.gathered), place_of_pair);
  BinnedSum energy;
  for (const BinnedSum& of_rank : all.notes) energy.add(of_rank);
  return energy.value();
}

void CollisionStage::repel(const MotionInputs& inputs, const std::vector<Contact>& contacts,
                           double step, Points& x1, FreeBodies& bodies) const {
  loomstone::repel(data_->model, inputs, contacts, step, x1, bodies);
}

CertifyReport CollisionStage::certify(const Team& team, const MotionInputs& inputs, Points& x1,
                                      FreeBodies& bodies) {
  if (data_->keeps_motion) data_->keep(inputs.x0, x1);
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
