#include "core/sim/step/integrate.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>

#include "core/sim/step/energy_account.h"

namespace loomstone {

namespace {

// Returns the factor on the tolerance of linear solves [1]. The factor is 1, divided by 10 for each
// full 0.25 in `gain`, the relative_gain(), but at least 1e-3. Our choice: with the default
// tolerance, errors of the solves would add 15 % to the energy of a free strip of 1e5 N/m and 0.03
// kg/m^2 that spins for 6 s, and 24 % to that of a pendulum on such a strip. Shorter parts would
// not prevent this. With contacts, this function is not used and the factor is 1: contacts may
// cause the gain, and with tighter solves, pins that jump through a curtain catch it more often.
double tolerance_factor(double gain) {
  return std::pow(10.0, -std::floor(std::clamp(4.0 * gain, 0.0, 3.0)));
}

// Further factor on the tolerance of linear solves [1] with the linearised midpoint rule and BDF-2.
// It applies to parts that have no contacts and that these schemes do not take by backward Euler.
// Our choice: with the default tolerance, a pendulum on a strip of 1e5 N/m and 0.03 kg/m^2 would
// swing with a period that is 5 % too long with a factor of 1, and 4 % with a factor of 0.1.
constexpr double undamped_factor = 0.01;

Elasticity::LimitPhaseScope limit_phase(const StepContext& part, const NearContacts& near,
                                        const State& state, Engines& engines) {
  if (!engines.limits_in_solve) return {};
  const Index n = engines.model.cloth.n_vertices;
  const bool all = engines.integrator->asks_energy();
  const Index first = all ? 0 : std::min(engines.layout.begin(), n);
  const Index last = all ? n : std::min(engines.layout.end(), n);
  return engines.elasticity->limit_phase(engines.team, state.cloth.x, first, last,
                                         near.yields.empty() ? nullptr : near.yields.data(),
                                         std::min(1.0, engines.recovery_rate * part.h));
}

// Returns the relative_gain(), or 0 if respond_to() does not use it.
double gain_before(const StepContext& part, const NearContacts& near, const Engines& engines,
                   const State& state) {
  const Integrator& scheme = *engines.integrator;
  const bool used = scheme.implicit() && !(scheme.damps() && near.any_terms);
  return used ? relative_gain(part, engines, state) : 0.0;
}

// Sets the members of `inputs` that depend on `gain`, the relative_gain().
void respond_to(double gain, const Engines& engines, bool in_contact, StepInputs& inputs) {
  inputs.damped = engines.integrator->implicit() && !engines.integrator->damps() &&
                  (engines.at_limits() || gain > 1.0);
  if (in_contact) return;
  inputs.tolerance_factor = tolerance_factor(gain);
  if (engines.integrator->keeps_neglected_energy() && !inputs.damped)
    inputs.tolerance_factor *= undamped_factor;
}

// Returns whether repeated solves limit excess friction (see ContactError). While pins move, it is
// accepted: with more accurate forces, pins that jump through a curtain hook into it more often.
bool limits_excess(const Model& model, const Loads& loads) {
  return !pins_move(model.cloth, loads);
}

// Passes the events of the asynchronous integrator to EventContacts, which handles contacts.
class CollisionsOfStep final : public EventCollisions {
 public:
  explicit CollisionsOfStep(EventContacts& contacts) : contacts_(contacts) {}
  void begin(Index n_ticks) override { contacts_.begin(n_ticks); }
  void act(const Team& team, Index tick, const EventMotion& motion) override {
    contacts_.act(team, tick, motion);
  }
  void act_on(const std::vector<Index>& vertices, const EventMotion& motion) override {
    contacts_.act_on(vertices, motion);
  }

 private:
  EventContacts& contacts_;
};

[[noreturn]] void fail_at_vertex(const NewtonFailure& failure, const Model& model,
                                 const Points& x0) {
  std::ostringstream out;
  out << failure.what() << "; the residual is largest at cloth vertex "
      << model.vertex_of_row(failure.row) << ", which began the step at (" << x0.row(failure.row)
      << ')';
  throw NewtonFailure(out.str(), failure.row);
}

}  // namespace

SolvedBodies integrate(const StepContext& part, const Loads& loads, NearContacts& near,
                       State& state, Engines& engines, StepReport& report) {
  const Model& model = engines.model;
  SolvedBodies solved{loads.body_velocity};
  if (model.cloth.n_vertices == 0) return solved;
  const double gain = gain_before(part, near, engines, state);
  const auto phase = limit_phase(part, near, state, engines);
  const TermsAt at = [&](const Points& displacement, double time, TermRequest request,
                         ExtraTerms& terms) {
    return terms_at(near, engines, displacement, time, request, terms);
  };
  const bool limit_excess = limits_excess(model, loads);
  const ForcesAfter forces = [&](const Points& displacement, double time, bool keep_normal,
                                 ExtraTerms& terms) {
    ContactError error = near.contact_terms.forces_after(engines.team, displacement, time,
                                                         model.inverse_mass, keep_normal, terms);
    if (near.terms_divided)
      engines.layout.communicator().add(error.sums.data(), ContactError::n_sums);
    return error.relative(keep_normal && limit_excess);
  };
  StepInputs inputs;
  inputs.step = part.h;
  inputs.time = part.t0;
  inputs.force = &loads.force;
  inputs.gravity = model.scene.gravity;
  inputs.terms = &near.terms;
  inputs.terms_at = &at;
  if (near.any_terms) inputs.forces_after = &forces;
  inputs.fixed = &model.prescribed;
  inputs.target = &loads.target;
  inputs.body_mass = &loads.body_mass;
  respond_to(gain, engines, near.any_terms, inputs);
  inputs.couples_bodies = model.n_bodies() > 0 &&
                          (near.any_terms || !near.tangle.empty() || !model.attachments.empty());
  const Points start = body_velocities(state.rigid);
  const BodiesOfStep bodies{&loads.body_poses, &start, &model.attachments, &solved.poses,
                            &solved.with_cloth};
  if (engines.integrator->moves_bodies()) {
    inputs.bodies = &bodies;
    solved.poses = loads.body_poses;
  }
  std::optional<CollisionsOfStep> collisions;
  if (engines.event_contacts) inputs.collisions = &collisions.emplace(*engines.event_contacts);
  try {
    const IntegrationReport done = engines.integrator->advance(engines.team, engines.layout, inputs,
                                                               state.cloth, solved.velocity);
    report.solver.newton_iterations += done.newton_iterations;
    report.solver.linear_iterations += done.linear_iterations;
    report.solver.residual = done.residual;
    report.solver.events += done.events;
    report.solver.synchronous_events += done.synchronous_events;
    if (engines.event_contacts) {
      report.contacts.evaluated += engines.event_contacts->n_evaluated();
      report.contacts.event_impulses += engines.event_contacts->n_impulses();
    }
  } catch (const NewtonFailure& failure) {
    fail_at_vertex(failure, model, loads.x0);
  }
  return solved;
}

}  // namespace loomstone
