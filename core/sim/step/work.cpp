#include "core/sim/step/work.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/rotation.h"
#include "core/parallel/merge_runs.h"
#include "core/sim/step/energies.h"

namespace loomstone {

namespace {

bool is_damped(const ClothModel& cloth) {
  const auto viscous = [](const MembraneConstants& c) {
    return c.lambda_d != 0.0 || c.mu_d != 0.0;
  };
  if (std::any_of(cloth.constants.begin(), cloth.constants.end(), viscous)) return true;
  return std::any_of(cloth.bending.begin(), cloth.bending.end(),
                     [](const auto& part) { return part.damping > 0.0; });
}

// Sums term(row) over all cloth rows. Each rank evaluates the rows that it owns.
template <class Term>
double sum_over_rows(const Engines& engines, Term&& term) {
  const RowLayout& layout = engines.layout;
  std::vector<double> sums((layout.n_rows() + rows_per_block - 1) / rows_per_block, 0.0);
  const Index last = std::min(layout.end(), engines.model.cloth.n_vertices);
  for (Index i = layout.begin(); i < last; ++i) sums[i / rows_per_block] += term(i);
  return layout.sum(sums);
}

// Returns the work of air and of the user's forces on cloth [J].
double work_of_loads(const Loads& loads, const State& state, const Engines& engines) {
  const Model& model = engines.model;
  return sum_over_rows(engines, [&](Index i) {
    const Vec3 force = loads.force.row(i).transpose() - model.cloth.mass[i] * model.scene.gravity;
    return force.dot((state.cloth.x.row(i) - loads.x0.row(i)).transpose());
  });
}

// Largest turn in a part that the rigid-body engine makes fully for all bodies [rad]. Beyond it,
// bodies in bearings that touch others turn too little.
constexpr double largest_exact_turn = M_PI / 4.0;

// Returns the rotation vector in world axes [rad] of a turn from `start` to `end`. The turn can
// exceed pi. The result is `guess`, which selects the number of whole turns, plus the rotation that
// remains when half of `guess` is undone before the turn and half after it. With the opposite
// guess, the reverse turn thus has the opposite vector.
Vec3 turn_near(const Vec3& guess, const Vec4& start, const Vec4& end) {
  const Vec4 back = quaternion_from_rotation_vector(-0.5 * guess);
  const Vec4 turn = quaternion_product(end, quaternion_inverse(start));
  return guess + rotation_vector(quaternion_product(back, quaternion_product(turn, back)));
}

// Returns the rotation vector of body b in the part, in world axes [rad]. If the body is not
// attached to cloth and spins fast enough to turn by more than largest_exact_turn, the vector
// follows from the mean of its angular velocities at both ends, otherwise from its orientations at
// both ends. A body that is attached to cloth can vibrate within the part, so this mean does not
// give its angle.
Vec3 turn_of_body(const StepContext& part, const Loads& loads, const State& state,
                  const Model& model, Index b) {
  const Vec3 first = loads.body_angular_velocity.row(b).transpose(),
             last = state.rigid.angular_velocities.row(b).transpose();
  const Vec3 mean = 0.5 * part.h * (first + last);
  const bool attached = std::any_of(model.attachments.begin(), model.attachments.end(),
                                    [&](const AttachedVertex& vertex) { return vertex.body == b; });
  if (!attached && part.h * std::max(first.norm(), last.norm()) > largest_exact_turn) return mean;
  return turn_near(mean, loads.body_poses[static_cast<std::size_t>(b)].orientation,
                   state.rigid.orientations.row(b).transpose());
}

// Returns the work of the user's forces and torques on bodies [J].
double work_on_bodies(const StepContext& part, const Loads& loads, const State& state,
                      const Model& model) {
  double work = 0.0;
  for (Index b = 0; b < state.body_force.rows(); ++b) {
    const Vec3 force = state.body_force.row(b).transpose(),
               torque = state.body_torque.row(b).transpose();
    if (force.isZero(0.0) && torque.isZero(0.0)) continue;
    const Vec3 moved = state.rigid.positions.row(b).transpose() -
                       loads.body_poses[static_cast<std::size_t>(b)].position;
    work += force.dot(moved) + torque.dot(turn_of_body(part, loads, state, model, b));
  }
  return work;
}

// Returns the elastic forces at x in owned rows (n x 3) [N]. Includes the viscous forces at the
// velocities v unless v is null.
Points inner_forces(const Points& x, const Points* v, Engines& engines) {
  const Index n = engines.model.cloth.n_vertices;
  const Index begin = std::min(engines.layout.begin(), n), end = std::min(engines.layout.end(), n);
  Points force = Points::Zero(n, 3);
  const Points none = v ? Points() : Points::Zero(n, 3);
  engines.elasticity->add_implicit_forces(engines.team, x, v, begin, end, force);
  engines.elasticity->add_explicit_bending(engines.team, x, v ? *v : none, begin, end, force);
  return force;
}

// Returns the viscous forces in owned rows (n x 3) [N], or no rows if no cloth is damped. The
// forces are those in the middle of the motion at its mean velocity. There, the rate of Green
// strain is exactly the change of this strain divided by the length of the part.
Points viscous_forces(const StepContext& part, const Loads& loads, const Solved& solved,
                      const State& state, Engines& engines) {
  if (!is_damped(engines.model.cloth)) return Points(0, 3);
  const Points start = loads.x0.topRows(engines.model.cloth.n_vertices);
  const Points &end = solved.positions(state.cloth), middle = 0.5 * (start + end),
               velocity = (end - start) / part.h;
  return inner_forces(middle, &velocity, engines) - inner_forces(middle, nullptr, engines);
}

// Returns the forces that limit phases exert in the solve, which moves the cloth from `start` to
// `end`, in owned rows (n x 3) [N].
Points limit_forces(const Points& start, const Points& end, Engines& engines) {
  const Index n = static_cast<Index>(start.rows());
  const Index first = std::min(engines.layout.begin(), n), last = std::min(engines.layout.end(), n);
  const auto at = [&](double share) {
    Points force = Points::Zero(n, 3);
    engines.elasticity->add_phase_forces(engines.team, start + share * (end - start), first, last,
                                         force);
    return force;
  };
  const double time = engines.integrator->time_of_forces();
  if (engines.integrator->asks_energy()) return at(time);
  return at(0.0) + time * (at(0.5) - at(-0.5));
}

// Returns the work of scripts that move prescribed vertices [J]. The work that these vertices do
// through contacts is not included.
double work_of_pins(const Loads& loads, const Points& viscous, const Solved& solved,
                    const State& state, Engines& engines) {
  const ClothModel& cloth = engines.model.cloth;
  if (!pins_move(cloth, loads)) return 0.0;
  const auto kinetic = [&](Index i) {
    return 0.5 * cloth.mass[i] *
           (state.cloth.v.row(i).squaredNorm() - loads.v0.row(i).squaredNorm());
  };
  if (const auto against_forces = engines.integrator->work_on_prescribed())
    return *against_forces +
           sum_over_rows(engines, [&](Index i) { return cloth.prescribed[i] ? kinetic(i) : 0.0; });
  const Points start = loads.x0.topRows(cloth.n_vertices);
  // Without damping, the forces at the start are still cached. Those at the end are computed last,
  // because the next part reuses them from the cache.
  const Points at_start = inner_forces(start, nullptr, engines);
  Points of_limits(0, 3);
  if (engines.limits_in_solve && engines.elasticity->in_limit_phase())
    of_limits = limit_forces(start, solved.positions(state.cloth), engines);
  Points force = 0.5 * (at_start + inner_forces(state.cloth.x, nullptr, engines)) +
                 loads.force.whole(cloth.n_vertices);
  if (viscous.rows() > 0) force += viscous;
  if (of_limits.rows() > 0) force += of_limits;
  return sum_over_rows(engines, [&](Index i) {
    if (!cloth.prescribed[i]) return 0.0;
    return kinetic(i) - force.row(i).dot(state.cloth.x.row(i) - start.row(i));
  });
}

// Returns two vectors for each term except those of attachments: the gradient of its energy in the
// solve [N], which is opposite to the force, and its relative displacement in the part [m]. In
// Newton schemes, also sets the gradients of the terms in `near` to the returned gradients.
std::vector<std::array<Vec3, 2>> solved_terms(const StepContext& part, NearContacts& near,
                                              const Points& displacement, const Engines& engines) {
  // Forces are evaluated at the same time within the step as in the scheme.
  const double time = engines.integrator->time_of_forces();
  // Newton schemes solve with the exact law of contacts, and other schemes with a linearised law.
  const bool newton = engines.integrator->asks_energy();
  if (newton)
    terms_at(near, engines, time * displacement, time * part.h, TermRequest::Derivative,
             near.terms);
  const ExtraTerms* const again = engines.integrator->terms_of_last_solve();
  const ExtraTerms& solved = again ? *again : near.terms;
  std::vector<std::array<Vec3, 2>> terms(near.terms.size() - near.n_attachments);
  parallel_for(
      engines.team, static_cast<Index>(terms.size()),
      [&](Index t) {
        const ExtraTerm& term = solved[t];
        const Vec3 d = term.relative_displacement(displacement, part.h);
        Vec3 force = term.gradient;  // gradient of the energy [N]
        if (!newton) force += time * term.hessian * d;
        terms[t] = {force, d};
      },
      128);
  return terms;
}

// The work that a contact adds to PartWork::scripts or PartWork::friction [J].
struct WorkOfContact {
  enum Sum : std::uint64_t { Scripts, Friction };
  WorkOfContact(const Contact& contact, Sum sum, double given)
      : place(2 * pair_order(contact) + sum), work(given) {}
  WorkOfContact() = default;
  Sum sum() const { return static_cast<Sum>(place % 2); }

  std::uint64_t place = 0;  // sort key: contact, then sum
  double work = 0.0;
};

// Returns the work that scripted surfaces and prescribed vertices do through the contacts that this
// rank counts (ContactTerms::counts()), and the work done against the friction of these contacts.
std::vector<WorkOfContact> work_of_terms(const StepContext& part, const NearContacts& near,
                                         const std::vector<std::array<Vec3, 2>>& terms,
                                         const Points& displacement, const Model& model) {
  std::vector<WorkOfContact> works;
  for (std::size_t t = 0; t < near.contact_terms.size(); ++t) {
    if (near.terms_divided && !near.contact_terms.counts(t)) continue;
    const ExtraTerm& term = near.terms[t];
    const auto& [force, d] = terms[t];
    const Vec3 normal = near.contact_terms.normal(t);
    const Contact& contact = near.contacts[near.contact_terms.contact(t)];
    const auto add = [&](WorkOfContact::Sum sum, double work) {
      if (work != 0.0) works.push_back({contact, sum, work});
    };
    add(WorkOfContact::Scripts, -part.h * force.dot(term.drift));
    for (int e = 0; e < term.n_entries; ++e) {
      const Index row = term.entries[e].row;
      if (row < model.cloth.n_vertices && model.cloth.prescribed[row])
        add(WorkOfContact::Scripts,
            force.dot(term.entries[e].apply(displacement.row(row).transpose())));
    }
    add(WorkOfContact::Friction, force.dot(d - d.dot(normal) * normal));
  }
  return works;
}

// Returns the work of the contacts of all ranks, in the order of the contacts. Collective.
std::vector<WorkOfContact> gathered(std::vector<WorkOfContact> works, const RowLayout& layout,
                                    GatherRoom& room) {
  auto all = gather_again<WorkOfContact, Index>(layout.communicator(), room, [&](Index& note) {
    note = 0;
    return std::move(works);
  });
  const auto before = [](const WorkOfContact& a, const WorkOfContact& b) {
    return a.place < b.place;
  };
  merge_runs(all.gathered.elements, all.gathered.start, before);
  return std::move(all.gathered.elements);
}

// Returns the work that scripted surfaces and prescribed vertices do through contacts, the work
// done against friction, and the work of untangling forces. With a Newton scheme, also changes the
// terms in `near` (see solved_terms()).
PartWork work_of_contacts(const StepContext& part, const Loads& loads, NearContacts& near,
                          const Solved& solved, const State& state, const Engines& engines) {
  PartWork work;
  if (!near.any_terms && near.terms.size() == near.n_attachments) return work;
  const Model& model = engines.model;
  const Index n = model.cloth.n_vertices;
  Points displacement(model.n_rows(), 3);
  displacement.topRows(n) = state.cloth.x - loads.x0.topRows(n);
  displacement.bottomRows(model.n_rows() - n) = part.h * solved.body_velocity;
  const std::vector<std::array<Vec3, 2>> terms = solved_terms(part, near, displacement, engines);
  std::vector<WorkOfContact> works = work_of_terms(part, near, terms, displacement, model);
  if (near.terms_divided) works = gathered(std::move(works), engines.layout, near.work_room);
  for (const WorkOfContact& of_contact : works)
    (of_contact.sum() == WorkOfContact::Scripts ? work.scripts : work.friction) += of_contact.work;
  for (std::size_t t = near.contact_terms.size(); t < terms.size(); ++t)
    work.loads -= terms[t][0].dot(terms[t][1]);
  return work;
}

}  // namespace

void note_solved(const Engines& engines, const State& state, const Points& body_velocity,
                 Solved& solved) {
  EnergyReport bodies;
  measure_bodies(engines.model, state.rigid, bodies);
  solved.x.resize(0, 3), solved.v.resize(0, 3);
  solved.body_velocity = body_velocity;
  solved.body_energy = bodies.body_kinetic + bodies.body_gravity;
}

bool surfaces_move(const Loads& loads) {
  if (loads.x0.rows() == 0) return false;  // there is no cloth
  return loads.x0.bottomRows(loads.next_obstacles.rows()) != loads.next_obstacles;
}

PartWork work_of_part(const StepContext& part, const Loads& loads, NearContacts& near,
                      const Solved& solved, const State& state, Engines& engines) {
  const double on_bodies = work_on_bodies(part, loads, state, engines.model);
  if (engines.model.cloth.n_vertices == 0)
    return {.scripts = solved.moved.obstacle_work, .loads = on_bodies};
  PartWork work = work_of_contacts(part, loads, near, solved, state, engines);
  work.scripts += solved.moved.obstacle_work;
  if (engines.event_contacts) {
    work.scripts += engines.event_contacts->work().prescribed;
    work.friction += engines.event_contacts->work().friction;
    work.loads += engines.event_contacts->work().restored;
  }
  const Points viscous = viscous_forces(part, loads, solved, state, engines);
  work.loads += work_of_loads(loads, state, engines) + on_bodies;
  work.scripts += work_of_pins(loads, viscous, solved, state, engines);
  if (viscous.rows() > 0) {
    const Points& end = solved.positions(state.cloth);
    work.damping = sum_over_rows(
        engines, [&](Index i) { return -viscous.row(i).dot(end.row(i) - loads.x0.row(i)); });
  }
  return work;
}

}  // namespace loomstone
