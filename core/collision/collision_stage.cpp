#include "core/collision/collision_stage.h"

#include <algorithm>

#include "core/collision/certify/clean_up.h"
#include "core/collision/certify/truncation.h"
#include "core/collision/response/contact_terms.h"
#include "core/collision/response/contacts.h"
#include "core/collision/response/repulsion.h"
#include "core/collision/response/untangling.h"

namespace loomstone {

// Rounds of detection and impulses before what is left is truncated. Three are enough where the
// cloth has room; plates that close to a twentieth of the thickness within a step needed up to ten.
constexpr int clean_up_rounds = 10;

struct CollisionStage::Data {
  explicit Data(const CollisionModel& given)
      : model(given),
        pairs(surface_pairs(model)),
        broad_phase(model, pairs),
        lists(model, pairs, broad_phase),
        tangle(model),
        search(model, broad_phase, lists, tangle) {}

  const CollisionModel& model;
  const std::vector<SurfacePair> pairs;
  BroadPhase broad_phase;
  NearLists lists;
  Tangle tangle;
  ImpactSearch search;
  std::vector<ContactLaw> laws;  // scratch: of the terms of this step
  ContactStart start;            // likewise, of its contacts
};

CollisionStage::CollisionStage(const CollisionModel& model)
    : data_(std::make_unique<Data>(model)) {}
CollisionStage::~CollisionStage() = default;

std::int64_t CollisionStage::find_tangle(const Points& x0) {
  data_->tangle.find(x0);
  return static_cast<std::int64_t>(data_->tangle.piercings().size());
}

void CollisionStage::forget_tangle() { data_->tangle.clear(); }

std::vector<Contact> CollisionStage::proximity(const Team& team, const Points& x0) {
  data_->lists.update(team, x0);
  std::vector<Contact> contacts = find_contacts(team, data_->model, data_->pairs, x0, data_->lists);
  if (!data_->tangle.empty())
    std::erase_if(contacts, [&](const Contact& contact) {
      return data_->tangle.leaves_out(contact.kind, pair_key(contact.a, contact.b),
                                      contact.vertices);
    });
  return contacts;
}

void CollisionStage::terms(const std::vector<Contact>& contacts, const Points& x0, const Points& v0,
                           const Points& last_change, const Points& body_centres, double step,
                           Index n_cloth, const ContactState& state, ExtraTerms& terms,
                           double& energy) {
  contact_terms(data_->model, contacts, x0, v0, last_change, body_centres, step, n_cloth, state,
                terms, data_->laws, data_->start, energy);
}

void CollisionStage::untangle(const Points& x0, const Points& v0, const Points& body_centres,
                              double step, Index n_cloth, ExtraTerms& terms) {
  untangling_terms(data_->model, data_->tangle, x0, v0, body_centres, step, n_cloth, terms);
}

double CollisionStage::terms_at(const Team& team, const Points& displacement, double time,
                                TermRequest request, ExtraTerms& terms) {
  return contact_terms_at(team, data_->laws, data_->model.contact_stiffness, displacement, time,
                          request, terms);
}

double CollisionStage::friction_at(const Team& team, const Points& displacement, double time,
                                   const Vector& inverse_mass, Index n_cloth, ExtraTerms& terms) {
  return contact_friction_at(team, data_->laws, data_->model.contact_stiffness, displacement, time,
                             inverse_mass, n_cloth, terms);
}

void CollisionStage::update_anchors(const std::vector<Contact>& contacts, const Points& x0,
                                    const Points& x1, ContactState& state) {
  update_contact_anchors(data_->model, contacts, x0, x1, data_->start, state);
}

void CollisionStage::repel(const std::vector<Contact>& contacts, const Points& x0, Points& x1,
                           const Vector& inverse_mass, double step, FreeBodies& bodies) {
  loomstone::repel(data_->model, contacts, data_->tangle, x0, inverse_mass, step, x1, bodies);
}

CertifyReport CollisionStage::certify(const Team& team, const Points& x0, Points& x1,
                                      const Vector& cloth_inverse_mass, FreeBodies& bodies) {
  Vector inverse_mass = cloth_inverse_mass;
  for (const CollisionSurface& surface : data_->model.surfaces)
    if (surface.kind != CollisionSurface::Kind::Cloth)
      inverse_mass.segment(surface.first_vertex, surface.n_vertices)
          .setConstant(surface.body >= 0 && !bodies.empty() ? bodies[surface.body].inverse_mass
                                                            : 0.0);
  std::vector<StepImpact> impacts = data_->search.find(team, x0, x1, inverse_mass, nullptr);
  const std::int64_t n_impacts = static_cast<std::int64_t>(impacts.size());
  if (n_impacts == 0) return {};

  CleanUp clean_up(data_->model, data_->pairs, inverse_mass, bodies);
  for (int round = 0; round < clean_up_rounds && !impacts.empty(); ++round) {
    clean_up.solve(impacts, x0, x1);
    impacts = data_->search.find(team, x0, x1, inverse_mass, nullptr);
  }
  CertifyReport report =
      truncate(team, data_->model, data_->search, x0, inverse_mass, std::move(impacts), x1, bodies);
  report.impacts = n_impacts;
  return report;
}

}  // namespace loomstone
