#include "core/sim/step/stepper.h"

#include <algorithm>
#include <optional>

#include "core/base/error.h"
#include "core/base/message.h"
#include "core/parallel/wait_policy.h"
#include "core/sim/step/checks.h"
#include "core/sim/step/energy_account.h"
#include "core/sim/step/integrate.h"
#include "core/sim/step/limit_and_certify.h"
#include "core/sim/step/move_bodies.h"
#include "core/sim/step/parts.h"
#include "core/sim/step/stage_timer.h"
#include "core/sim/step/step_error.h"
#include "core/sim/step/strain_rate.h"

namespace loomstone {

Stepper::Stepper(const Model& model, const IntegratorOptions& options, StepChoice steps,
                 const Workers& workers, const State& state)
    : steps_(steps),
      engines_(model, options, workers, state),
      threads_(workers.team.threads, threads_sleep() || !workers.layout.single()) {}

void Stepper::advance(State& state, StepOutcome& outcome) {
  const Communicator& ranks = engines_.layout.communicator();
  const Traffic traffic_before = ranks.traffic();
  double wall = 0.0;
  std::optional<StageTimer> timer(wall);
  state.rigid.manifolds.clear();  // manifolds are saved again when needed
  const EnergyAccount before = state.account;
  begin_account(engines_, state);
  outcome.start = state;
  save_world(engines_, outcome.start);
  StepOutcome last = begin_outcome(state.step, engines_.model.cloth.n_vertices, outcome);
  std::fill(engines_.busy.begin(), engines_.busy.end(), 0.0);
  engines_.team.threads = engines_.collision_team.threads = threads_.threads();
  threads_.start();
  try {
    const StepSpan span =
        take_parts(steps_, engines_, state, outcome,
                   [&](const StepContext& part) { return run_stages(part, state, outcome); });
    finish(span, state, outcome);
    threads_.stop();
    timer.reset();
    RankReport& of_ranks = outcome.report.ranks;
    of_ranks = summary_of(ranks, work_of_step(ranks, traffic_before, wall, of_ranks));
  } catch (const Error& error) {
    return_to_state(outcome.start, engines_, state);
    state.account = before;
    end_failed(std::move(last), outcome);
    if (!dynamic_cast<const SolverFailure*>(&error)) throw;
    fail<SolverFailure>("step {} (from time {:g} s) failed: {}", state.step + 1, state.time,
                        error.what());
  }
}

// Runs a stage of collision handling. Adds its wall time to `seconds`, and its computing and
// waiting times to `report`.
template <class Stage>
void Stepper::collide(double& seconds, StepReport& report, Stage&& stage) {
  const Communicator& ranks = engines_.layout.communicator();
  const double waiting_before = ranks.traffic().waiting, seconds_before = seconds;
  timed(seconds, stage);
  const double waiting = ranks.traffic().waiting - waiting_before;
  report.ranks.collision_waiting += waiting;
  report.ranks.collision_computing += seconds - seconds_before - waiting;
}

PartResult Stepper::run_stages(const StepContext& part, State& state, StepOutcome& outcome) {
  StepReport& report = outcome.report;
  StageSeconds& seconds = report.seconds;
  SolvedBodies bodies;
  Certified certified;
  StepError error;
  AfterSolve after;
  PartResult energy;
  timed(seconds.loads, [&] { find_loads(part, state, engines_, loads_); });
  collide(seconds.proximity, report,
          [&] { find_near_contacts(part, loads_, state, engines_, near_, report); });
  timed(seconds.integrate, [&] {
    bodies = integrate(part, loads_, near_, state, engines_, report);
    // Certification requires finite positions.
    check_divergence(engines_.model, loads_.x0, state.cloth, "integrate");
  });
  timed(seconds.check, [&] { error = error_of_motion(part, loads_, state, engines_); });
  if (too_large(part, error, engines_)) return shorter(part, error, engines_);
  timed(seconds.bodies,
        [&] { solved_.moved = move_bodies(part, loads_, bodies, state, engines_, report); });
  note_solved(engines_, state, bodies.velocity, solved_);
  collide(seconds.certify, report,
          [&] { certified = limit_and_certify(part, loads_, near_, state, engines_, outcome); });
  if (certified.moved) solved_.x.swap(certified.solved_x), solved_.v.swap(certified.solved_v);
  timed(seconds.limit, [&] {
    after.limited =
        certified.limited + limit_strain_rate(part, certified, solved_, state, engines_, outcome);
  });
  timed(seconds.check, [&] {
    if (certified.moved) error = error_of_motion(part, loads_, state, engines_);
  });
  if (too_large(part, error, engines_)) return shorter(part, error, engines_);
  // The next part reuses the contacts that know_contacts() finds.
  collide(seconds.proximity, report, [&] { know_contacts(state, engines_); });
  timed(seconds.check, [&] {
    note_error(part, error, engines_, report);
    after.untangles = !near_.tangle.empty(), after.surfaces_move = surfaces_move(loads_);
    const PartWork work = work_of_part(part, loads_, near_, solved_, state, engines_);
    const double gained = add_to_account(work, solved_, after, engines_, state);
    energy = check_energy(part, loads_, near_, gained, engines_, state);
  });
  if (energy.longest < part.length) return energy;
  state.cloth.previous_step = part.h;
  timed(seconds.check, [&] { expect_part(part, error, engines_, state.cloth); });
  return certified.result;
}

void Stepper::finish(const StepSpan& span, State& state, StepOutcome& outcome) {
  StepReport& report = outcome.report;
  solved_ = {};
  report.busy = summary_of(engines_.busy);
  const StageTimer timer(report.seconds.check);
  ++state.step;
  state.time = report.time = span.t1;
  if (steps_.automatic) expect_step(steps_.largest, outcome.start, span.h, near_, engines_, state);
  report.length = span.h;
  check_divergence(engines_.model, loads_.x0, state.cloth, "certify");
  if (report.contacts.unresolved > 0) state.tangled = 2;
  if (engines_.collision && state.tangled) count_intersections(state, engines_, outcome);
  measure_contacts(engines_.model, state, span.h, outcome);
  // Rebuilds the world from State after every rigid_rebuild_interval steps, so that later results
  // do not depend on checkpoints.
  if (engines_.world && state.step % engines_.model.scene.rigid_rebuild_interval == 0) {
    engines_.world->save(state.rigid);
    engines_.world->restore(state.rigid);
  }
}

std::size_t Stepper::step_bytes() const {
  return bytes_of(loads_, near_.v0, solved_.x, solved_.v, engines_.error) +
         engines_.integrator->memory().vectors;
}

std::size_t Stepper::contact_bytes() const {
  return bytes_of(near_.contacts, near_.repelled, near_.terms, near_.contact_terms) +
         (engines_.collision ? engines_.collision->contact_bytes() : 0);
}

}  // namespace loomstone
