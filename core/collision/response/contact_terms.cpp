#include "core/collision/response/contact_terms.h"

#include <algorithm>
#include <cmath>

#include "core/collision/model/rigid_motion.h"
#include "core/collision/response/contacts.h"
#include "core/collision/response/friction.h"
#include "core/collision/response/term_entries.h"

namespace loomstone {

namespace {

// A contact can count as closing only if its predicted gap is less than this fraction of its gap at
// the start. Our choice. For the second condition, see is_closing().
constexpr double closing = 0.25;

// Weight of the ratio of pulling to pushing normal forces in ContactError::relative(). Our choice:
// with a weight of 1, steps are solved again more often, and cloth leaves surfaces no faster.
constexpr double weight_of_pull = 0.5;
// Weight of the ratio of excess friction to the friction limit in ContactError::relative(). Errors
// of single contacts change their sign from step to step, but an excess in all contacts brakes the
// whole cloth. Our choice: with a weight of 0, cloth slides over round bars in automatic steps as
// if the friction coefficient were up to 1.5 times as large (docs/experiments/contacts.md).
constexpr double weight_of_excess = 10.0;

Mat3 tangent_projector(const Vec3& normal) {
  return Mat3::Identity() - normal * normal.transpose();
}

// Returns the difference of a field between the two contact points: the sum of w_i f_i over the
// four vertices.
template <class Field>
Vec3 weighted(const Contact& contact, const Field& field) {
  Vec3 sum = Vec3::Zero();
  for (int i = 0; i < 4; ++i)
    sum += contact.weights[i] * field.row(contact.vertices[i]).transpose();
  return sum;
}

// Largest allowed slope of a normal force, in units of M / h^2. Here h is the step, and M is the
// effective mass of the contact's free cloth vertices: 1 / M is the sum of w_i^2 / m_i. Our choice.
// With a larger slope, the matrix could lose positive definiteness in single precision.
constexpr double rigid = 1e8;

// The signed gap at which the force law is evaluated, and the gap below which the law is extended
// linearly [m].
struct Gaps {
  double signed_gap, linear;
};

ContactForce extended_force(const Gaps& gaps, double thickness, double stiffness) {
  const auto [gap, linear] = gaps;
  if (gap >= linear) return contact_force(gap, thickness, stiffness);
  const ContactForce at = contact_force(linear, thickness, stiffness);
  const double depth = linear - gap;
  return {at.force + at.stiffness * depth, at.stiffness,
          at.energy + (at.force + 0.5 * at.stiffness * depth) * depth};
}

// Returns the gap [m] below which the slope of the force law would exceed `steepest` [N/m], but at
// most half the thickness.
double steepest_gap(double thickness, double stiffness, double steepest) {
  return 0.5 * thickness * std::sqrt(std::min(1.0, stiffness / steepest));
}

// Evaluates the force law at the signed gap of an iterate. The law is extended linearly below the
// larger of two gaps: steepest_gap(), and the smaller of a tenth of the thickness and the distance
// at the start. A finite force therefore pushes back an iterate that has passed through the
// surface.
ContactForce force_at_gap(const ContactLaw& law, double gap) {
  const double tenth = std::min(0.1 * law.thickness, law.distance);
  const double linear =
      std::max(tenth, steepest_gap(law.thickness, law.normal_stiffness, law.steepest));
  return extended_force({gap, linear}, law.thickness, law.normal_stiffness);
}

ContactForce force_at_start(const ContactLaw& law) {
  const double linear = steepest_gap(law.thickness, law.normal_stiffness, law.steepest);
  return extended_force({law.distance, linear}, law.thickness, law.normal_stiffness);
}

// Returns whether a contact is predicted to close, for a change of the gap by `along` [m].
bool is_closing(const ContactLaw& law, double tangential, const ContactForce& start, double along) {
  // Near the onset of the law, a contact is too soft to stop even a gentle motion within the step.
  // Such a contact counts as closing only if its stiffness, as determined by contact_stiffness()
  // and multiplied by the share, is greater than the contact stiffness of the model.
  const bool resists = law.normal_stiffness > tangential || start.stiffness >= law.normal_stiffness;
  return resists && law.distance + along < closing * law.distance;
}

// Returns the predicted force of a contact that closes, for a change of the gap by `along` [m].
// Near the onset of the law, its tangent is almost zero and underestimates the force at smaller
// gaps. The prediction therefore uses at least `normal_stiffness`.
double closing_force(const ContactLaw& law, const ContactForce& start, double along) {
  return start.force - std::max(start.stiffness, law.normal_stiffness) * along;
}

// Returns the secant stiffness of the force law [N/m], at most law.steepest. It replaces the
// tangent stiffness of a contact that is predicted to close. The secant leads from the gap at which
// the law gives the force at the start to the gap at which it gives `predicted`, the result of
// closing_force() [N].
double secant_stiffness(const ContactLaw& law, const ContactForce& start, double predicted) {
  const double half = 0.5 * law.thickness, offset = 0.25 * law.normal_stiffness * half;
  const auto gap = [&](double force) {
    return law.normal_stiffness * half * half / (force + offset);
  };
  const double from = law.distance > half ? law.distance : gap(start.force);
  return std::min((predicted - start.force) / (from - gap(predicted)), law.steepest);
}

// Number of contacts in each range of a parallel loop.
constexpr Index contacts_at_once = 64;

// A contact at the start of the step.
struct AtStart {
  ActingOn acting;
  // Stiffness in the normal direction, not multiplied by the share [N/m], and largest slope allowed
  // for the product of share and normal force [N/m]. `normal` is normal_at_start().
  double stiffness = 0.0, steepest = 0.0;
  ContactForce normal{};
};

// Returns the largest slope allowed for the normal force of a contact [N/m].
double steepest_slope(const Contact& contact, const ContactInputs& inputs) {
  double inverse_mass = 0.0;
  for (int i = 0; i < 4; ++i)
    inverse_mass +=
        contact.weights[i] * contact.weights[i] * inputs.inverse_mass[contact.vertices[i]];
  return rigid / (inputs.step * inputs.step * std::max(inverse_mass, 1e-300));
}

// Returns the normal force at the start of the step, not multiplied by the share. The share affects
// only the gap below which the force law is extended linearly.
ContactForce normal_at_start(const Contact& contact, const AtStart& start, double share) {
  const double linear = steepest_gap(contact.thickness, share * start.stiffness, start.steepest);
  return extended_force({contact.distance, linear}, contact.thickness, start.stiffness);
}

// Returns the law of a contact. Does not set its members `parting`, `contact` and `counts`.
ContactLaw law_at_start(const Contact& contact, const AtStart& start, double share,
                        const Vec3& slip) {
  ContactLaw law;
  law.normal = contact.normal;
  law.distance = contact.distance, law.thickness = contact.thickness;
  law.share = share, law.friction = contact.friction;
  law.slip = slip;
  law.limit = contact.friction * share * start.normal.force;
  law.normal_stiffness = share * start.stiffness, law.steepest = start.steepest;
  return law;
}

// Returns the sum of w_i^2 / m_i over the cloth rows of a term [1/kg].
double compliance(const ExtraTerm& term, Index n_cloth, const Vector& inverse_mass) {
  double sum = 0.0;
  for (int e = 0; e < term.n_entries; ++e)
    if (const TermEntry& entry = term.entries[e]; entry.row < n_cloth)
      sum += entry.weight * entry.weight * inverse_mass[entry.row];
  return sum;
}

// Sets the gradient and Hessian of a term from normal_at_start(), given as `normal`, and from
// friction after the predicted motion. `stiffness` is the anchor stiffness times the share [N/m].
void set_forces(const Contact& contact, const ContactInputs& inputs, double stiffness,
                const ContactForce& normal, const ContactLaw& law, ExtraTerm& term) {
  const Mat3 tangent = tangent_projector(law.normal);
  Vec3 of_obstacles = Vec3::Zero();  // weighted sum of the changes of obstacle velocities [m/s]
  for (int i = 0; i < 4; ++i)
    if (const Index v = contact.vertices[i]; v >= inputs.n_cloth)
      of_obstacles += contact.weights[i] * inputs.change.row(v).transpose();
  const Vec3 predicted = inputs.step * (tangent * (weighted(contact, inputs.v0) - of_obstacles));
  const Vec3 gained = inputs.step * (tangent * weighted(contact, inputs.change));
  const FrictionResponse friction =
      friction_response(law.slip, sped_up(law.slip, predicted, gained, stiffness, law.limit),
                        tangent, stiffness, law.limit);
  term.gradient = -law.share * normal.force * law.normal + friction.gradient;
  term.hessian = law.share * normal.stiffness * (Mat3::Identity() - tangent) + friction.hessian;
}

// Error of the forces in one term; see ContactError.
struct TermError {
  double wrong = 0.0, excess = 0.0, limit = 0.0;  // of friction [N]
  double normal = 0.0;                            // normal force, positive if it pushes [N]
  bool closes = false;
};

void add_error(const TermError& term, ContactError& error) {
  error.sums[ContactError::Wrong].add(term.wrong);
  error.sums[ContactError::Excess].add(term.excess);
  error.sums[ContactError::Limit].add(term.limit);
  error.sums[ContactError::Pull].add(std::max(0.0, -term.normal));
  error.sums[ContactError::Push].add(std::max(0.0, term.normal));
  error.sums[ContactError::Closing].add(term.closes ? 1.0 : 0.0);
}

}  // namespace

ContactTerms::ContactTerms(const Team& team, const CollisionModel& model,
                           const ContactInputs& inputs, const std::vector<Contact>& contacts,
                           const ContactStrengths& strengths, ExtraTerms& terms)
    : shares_(strengths.shares),
      slips_(strengths.slips),
      forces_(contacts.size(), 0.0),
      tangential_(model.contact_stiffness),
      n_cloth_(inputs.n_cloth) {
  std::vector<AtStart> starts(contacts.size());
  parallel_for(
      team, static_cast<Index>(contacts.size()),
      [&](Index c) {
        AtStart& start = starts[c];
        start.acting = acting_on(model, contacts[c], inputs.rows);
        if (!start.acting.given && !start.acting.counts) return;
        start.stiffness = strengths.stiffness[c];
        start.steepest = steepest_slope(contacts[c], inputs);
        start.normal = normal_at_start(contacts[c], start, shares_[c]);
        forces_[c] = start.normal.force;
      },
      contacts_at_once);
  counted_.reserve(std::count_if(starts.begin(), starts.end(),
                                 [](const AtStart& start) { return start.acting.counts; }));
  std::vector<Index> with_term;
  for (Index c = 0; c < static_cast<Index>(contacts.size()); ++c) {
    const ActingOn& acting = starts[c].acting;
    if (acting.counts) counted_.push_back(c);
    if (shares_[c] <= 0.0 || !acting.any) continue;
    if (acting.counts) {
      const double stiffness = shares_[c] * tangential_;
      energy_.add(shares_[c] * starts[c].normal.energy + 0.5 * stiffness * slips_[c].squaredNorm());
      ++n_counted_;
    }
    if (acting.given) with_term.push_back(c);
  }
  const std::size_t first = terms.size();
  terms.resize(first + with_term.size());
  laws_.resize(with_term.size());
  parallel_for(
      team, static_cast<Index>(with_term.size()),
      [&](Index i) {
        const Index c = with_term[i];
        const Contact& contact = contacts[c];
        const double share = shares_[c];
        ContactLaw& law = laws_[i];
        ExtraTerm& term = terms[first + i];
        set_entries(model, contact.vertices, contact.weights, inputs, term);
        law = law_at_start(contact, starts[c], share, slips_[c]);
        law.parting = law.normal.dot(weighted(contact, inputs.v0));
        law.contact = c;
        law.counts = inputs.rows.contains(term.entries[0].row);
        set_forces(contact, inputs, share * tangential_, starts[c].normal, law, term);
      },
      contacts_at_once);
}

double ContactTerms::at(const Team& team, const Points& displacement, double time,
                        TermRequest request, ExtraTerms& terms) {
  return parallel_sum(team, static_cast<Index>(laws_.size()), [&](Index i) {
    ContactLaw& law = laws_[i];
    ExtraTerm& term = terms[i];
    const Vec3 moved = term.relative_displacement(displacement, time);
    const double along = law.normal.dot(moved), k = law.share * tangential_;
    const ContactForce normal = force_at_gap(law, law.distance + along);
    const Mat3 tangent = tangent_projector(law.normal);
    if (request == TermRequest::NewLimits) law.limit = law.friction * normal.force;
    const FrictionState friction =
        loomstone::friction_at(law.slip, moved - along * law.normal, tangent, k, law.limit,
                               request == TermRequest::Secant);
    term.gradient = friction.gradient - normal.force * law.normal;
    term.hessian = friction.hessian + normal.stiffness * (Mat3::Identity() - tangent);
    return normal.energy + friction.energy;
  });
}

double ContactError::relative(bool limit_excess) const {
  if (sums[Closing].value() > 0.0) return 1.0;
  const auto ratio = [&](int error, int of) {
    const double wrong = sums[error].value();
    return wrong > 0.0 ? wrong / std::max(sums[of].value(), 1e-300) : 0.0;
  };
  const double excess = limit_excess ? weight_of_excess * ratio(Excess, Limit) : 0.0;
  return std::max({ratio(Wrong, Limit), weight_of_pull * ratio(Pull, Push), excess});
}

ContactError ContactTerms::forces_after(const Team& team, const Points& displacement, double time,
                                        const Vector& inverse_mass, bool keep_normal,
                                        ExtraTerms& terms) const {
  std::vector<TermError> errors(laws_.size());
  parallel_for(
      team, static_cast<Index>(laws_.size()),
      [&](Index i) {
        const ContactLaw& law = laws_[i];
        ExtraTerm& term = terms[i];
        const Vec3 &n = law.normal, moved = term.relative_displacement(displacement, time);
        const double along = n.dot(moved), k = law.share * tangential_;
        ContactForce normal = force_at_start(law);
        if (keep_normal)
          normal.force = -n.dot(term.gradient), normal.stiffness = n.dot(term.hessian * n);
        const double solved = normal.force - normal.stiffness * along;  // force in the solve [N]
        double at_end = std::max(0.0, solved);                          // expected force [N]
        const bool closes = !keep_normal && is_closing(law, tangential_, normal, along);
        if (closes) {
          at_end = closing_force(law, normal, along);
          normal.stiffness = secant_stiffness(law, normal, at_end);
        } else if (solved < 0.0) {
          const double apart = std::max(along, time * law.parting);
          at_end = force_at_gap(law, law.distance + apart).force;
          normal.stiffness = (normal.force - at_end) / apart;
        }
        // A contact that still pulls in a repeated solve has no friction: its normal force at the
        // gap after the motion is often far larger than its normal force in the next solve.
        const double limit = solved < 0.0 && keep_normal ? 0.0 : law.friction * at_end;
        const Mat3 tangent = tangent_projector(n);
        Vec3 slipped = moved - along * n;
        const Vec3 had = tangent * (term.gradient + term.hessian * moved);
        const double trial = k * (law.slip + slipped).norm(), size = slipped.norm();
        const Vec3 due = (trial > limit ? limit / trial : 1.0) * k * (law.slip + slipped);
        const Vec3 error = had - due;
        const double excess = size > 0.0 ? error.dot(slipped) / size : 0.0;
        errors[i] = {error.norm(), excess, limit, solved, closes};

        // If friction was too large, the contact slips further once the excess is removed. `more`
        // is the predicted additional slip [m].
        const double more =
            time * time * compliance(term, n_cloth_, inverse_mass) * (had.norm() - limit);
        if (trial > limit && size > 0.0 && more > 0.0) slipped *= 1.0 + more / size;
        const FrictionResponse friction = friction_response(law.slip, slipped, tangent, k, limit);
        term.gradient = -normal.force * n + friction.gradient;
        term.hessian = normal.stiffness * (Mat3::Identity() - tangent) + friction.hessian;
      },
      128);
  ContactError error;
  for (std::size_t i = 0; i < errors.size(); ++i)
    if (laws_[i].counts) add_error(errors[i], error);
  return error;
}

std::vector<ContactState::Anchor> ContactTerms::anchors(const CollisionModel& model,
                                                        const std::vector<Contact>& contacts,
                                                        const Points& x0, const Points& x1) const {
  std::vector<RigidMotion> motions(model.surfaces.size());
  std::vector<std::uint8_t> known(model.surfaces.size(), 0);
  std::vector<ContactState::Anchor> anchors;
  anchors.reserve(counted_.size());
  for (const Index c : counted_) {
    const Contact& contact = contacts[c];
    const double force = forces_[c];
    const Vec3 moved = weighted(contact, x1) - weighted(contact, x0);
    const Vec3 actual = moved - contact.normal * contact.normal.dot(moved);
    Vec3 slip = slip_after(slips_[c], actual, tangential_, contact.friction * force);
    // If a surface of the contact is a rigidly moving body or obstacle, the slip rotates with it.
    for (const int corner : {0, 3}) {
      const Index s = model.surface_of_vertex(contact.vertices[corner]);
      if (model.surfaces[s].kind == CollisionSurface::Kind::Cloth) continue;
      if (!known[s]) {
        motions[s] = rigid_motion(model, s, x0, x1);
        known[s] = 1;
      }
      if (motions[s].rigid) slip = motions[s].rotation * slip;
    }
    anchors.push_back({contact.kind, contact.a, contact.b, slip, shares_[c] * force});
  }
  return anchors;
}

std::vector<BinnedSum> contact_energies(const CollisionModel& model, const ContactMotion& motion,
                                        const std::vector<Contact>& contacts,
                                        const ContactStrengths& strengths, IndexRange rows) {
  const int n = motion.n_parts;
  std::vector<BinnedSum> energies(n);
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const Contact& contact = contacts[c];
    if (!acting_on(model, contact, rows).counts) continue;
    const double anchor = 0.5 * model.contact_stiffness * strengths.slips[c].squaredNorm();
    const double change =
        n == 1 ? 0.0
               : contact.normal.dot(weighted(contact, motion.x) - weighted(contact, motion.x0));
    for (int part = 1; part <= n; ++part) {
      const double done = static_cast<double>(part) / n;  // fraction of the motion
      const double distance = contact.distance - (1.0 - done) * change;
      const double normal =
          contact_force(distance, contact.thickness, strengths.stiffness[c]).energy;
      energies[part - 1].add(strengths.shares[c] * (normal + done * done * anchor));
    }
  }
  return energies;
}

}  // namespace loomstone
