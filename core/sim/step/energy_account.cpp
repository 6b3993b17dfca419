#include "core/sim/step/energy_account.h"

#include <algorithm>

#include "core/sim/step/energies.h"

namespace loomstone {

namespace {

bool pins_move(const Engines& engines, const Loads& loads, const State& state) {
  const ClothModel& cloth = engines.model.cloth;
  for (Index i = 0; i < cloth.n_vertices; ++i)
    if (cloth.prescribed[i] && state.cloth.x.row(i) != loads.x0.row(i)) return true;
  return false;
}

bool surfaces_move(const Loads& loads) {
  return loads.x0.bottomRows(loads.next_obstacles.rows()) != loads.next_obstacles;
}

double kinetic_energy(const ClothModel& cloth, const Points& v) {
  double sum = 0.0;
  for (Index i = 0; i < cloth.n_vertices; ++i) sum += cloth.mass[i] * v.row(i).squaredNorm();
  return 0.5 * sum;
}

// Sums term(row) over all cloth rows. Each rank evaluates the rows that it owns.
template <class Term>
double sum_over_rows(const Engines& engines, Term&& term) {
  const RowLayout& layout = engines.layout;
  std::vector<double> sums((layout.n_rows() + rows_per_block - 1) / rows_per_block, 0.0);
  const Index last = std::min(layout.end(), engines.model.cloth.n_vertices);
  for (Index i = layout.begin(); i < last; ++i) sums[i / rows_per_block] += term(i);
  return layout.ordered_sum(sums);
}

// Work of air and of the user's forces.
double work_of_loads(const Loads& loads, const State& state, const Engines& engines) {
  const Model& model = engines.model;
  return sum_over_rows(engines, [&](Index i) {
    const Vec3 force = loads.force.row(i).transpose() - model.cloth.mass[i] * model.scene.gravity;
    return force.dot((state.cloth.x.row(i) - loads.x0.row(i)).transpose());
  });
}

// Mean of the elastic forces at the start and the end of the part, in owned rows (n x 3) [N].
Points mean_elastic_force(const Loads& loads, const State& state, Engines& engines) {
  const Index n = engines.model.cloth.n_vertices;
  const Index begin = std::min(engines.layout.begin(), n), end = std::min(engines.layout.end(), n);
  Points force = Points::Zero(n, 3);
  const Points start = loads.x0.topRows(n), none = Points::Zero(n, 3);
  for (const Points* const x : {&start, &state.cloth.x}) {
    engines.elasticity->add_implicit_forces(engines.team, *x, nullptr, begin, end, force);
    engines.elasticity->add_explicit_bending(engines.team, *x, none, begin, end, force);
  }
  return 0.5 * force;
}

// Work on prescribed vertices, without that of contacts.
double work_of_pins(const Loads& loads, const State& state, Engines& engines) {
  if (!pins_move(engines, loads, state)) return 0.0;
  const ClothModel& cloth = engines.model.cloth;
  const Points force = mean_elastic_force(loads, state, engines) + loads.force;
  return sum_over_rows(engines, [&](Index i) {
    if (!cloth.prescribed[i]) return 0.0;
    const double kinetic =
        0.5 * cloth.mass[i] * (state.cloth.v.row(i).squaredNorm() - loads.v0.row(i).squaredNorm());
    return kinetic - force.row(i).dot(state.cloth.x.row(i) - loads.x0.row(i));
  });
}

// Work of scripted surfaces and prescribed vertices through contacts, the work against friction,
// and the work of forces that untangle.
struct ContactWork {
  double scripts = 0.0, friction = 0.0, untangling = 0.0;
};

ContactWork work_of_contacts(const StepContext& part, const Loads& loads, NearContacts& near,
                             const Points& body_velocity, const State& state,
                             const Engines& engines) {
  ContactWork work;
  const std::size_t n_contacts = near.contact_terms.size();
  const std::size_t n_terms = near.terms.size() - near.n_attachments;
  if (n_terms == 0) return work;
  const Model& model = engines.model;
  const Index n = model.cloth.n_vertices;
  Points displacement(model.n_rows(), 3);
  displacement.topRows(n) = state.cloth.x - loads.x0.topRows(n);
  displacement.bottomRows(model.n_rows() - n) = part.h * body_velocity;
  ExtraTerms terms = near.terms;
  // Forces are those at the time at which the scheme evaluates them.
  const double time = engines.integrator->time_of_forces();
  const bool newton = engines.integrator->asks_energy();  // the scheme solves with the exact law
  if (newton)
    terms_at(near, engines, time * displacement, time * part.h, TermRequest::Derivative, terms);
  else
    near.contact_terms.friction_at(engines.team, time * displacement, time * part.h,
                                   model.inverse_mass, terms);
  for (std::size_t t = 0; t < n_terms; ++t) {
    const ExtraTerm& term = terms[t];
    const Vec3 d = term.relative_displacement(displacement, part.h);
    Vec3 force = term.gradient;  // gradient of the energy [N]
    if (!newton) force += time * term.hessian * d;
    if (t >= n_contacts) {
      work.untangling -= force.dot(d);
      continue;
    }
    const Vec3 normal = near.contact_terms.normal(t);
    work.scripts -= part.h * force.dot(term.drift);
    for (int e = 0; e < term.n_entries; ++e) {
      const Index row = term.entries[e].row;
      if (row < n && model.cloth.prescribed[row])
        work.scripts += force.dot(term.entries[e].apply(displacement.row(row).transpose()));
    }
    work.friction += force.dot(d - d.dot(normal) * normal);
  }
  return work;
}

// Energy of everything but contacts. Circuits count with what they have received and lost [J].
double total_energy(const StepReport& report) {
  const EnergyReport& e = report.energy;
  const CircuitReport& c = report.circuits;
  return e.kinetic + e.membrane + e.bending + e.gravity + e.body_kinetic + e.body_gravity +
         e.magnetic + c.energy + c.heat + c.bearing_work - c.supply;
}

double largest_kinetic(const State& state, const Engines& engines) {
  EnergyReport bodies;
  measure_bodies(engines.model, state.rigid, bodies);
  return kinetic_energy(engines.model.cloth, state.cloth.v) + bodies.body_kinetic;
}

}  // namespace

void begin_account(const Engines& engines, State& state) {
  if (state.account.begun) return;
  StepReport report;
  measure_energies(state, state.time, engines, report);
  state.account = {};
  state.account.begun = true;
  state.account.start = total_energy(report);
  state.account.largest_kinetic = largest_kinetic(state, engines);
}

void add_to_account(const StepContext& part, const Loads& loads, NearContacts& near,
                    const SolvedVelocities& solved, Engines& engines, State& state) {
  EnergyAccount& account = state.account;
  if (engines.model.cloth.n_vertices > 0) {
    const ContactWork contacts = work_of_contacts(part, loads, near, solved.bodies, state, engines);
    account.loads += work_of_loads(loads, state, engines) + contacts.untangling;
    account.scripts += work_of_pins(loads, state, engines) + contacts.scripts;
    account.friction += contacts.friction;
    const double lost = kinetic_energy(engines.model.cloth, solved.cloth) -
                        kinetic_energy(engines.model.cloth, state.cloth.v);
    // Only forces that untangle and scripted motion give energy to cloth.
    if (lost < 0.0 && !near.tangle.empty())
      account.loads -= lost;
    else if (lost < 0.0 && surfaces_move(loads))
      account.scripts -= lost;
    else
      account.withheld += lost;
  }
  account.largest_kinetic = std::max(account.largest_kinetic, largest_kinetic(state, engines));
}

void report_account(const State& state, StepReport& report) {
  const EnergyAccount& account = state.account;
  AccountReport& to = report.account;
  to = {};
  if (!account.begun) return;
  to.scripts = account.scripts, to.loads = account.loads;
  to.friction = account.friction, to.withheld = account.withheld;
  const double gain = total_energy(report) - account.start - account.scripts - account.loads;
  to.lost = -gain - account.friction - account.withheld;
  if (account.largest_kinetic > 0.0) to.balance = gain / account.largest_kinetic;
}

}  // namespace loomstone
