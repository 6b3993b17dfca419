#include "core/sim/step/stepper.h"

#include <algorithm>
#include <optional>
#include <sstream>

#include "core/base/error.h"
#include "core/parallel/wait_policy.h"
#include "core/sim/model/motion.h"
#include "core/sim/step/checks.h"
#include "core/sim/step/energy_account.h"
#include "core/sim/step/integrate.h"
#include "core/sim/step/limit_and_certify.h"
#include "core/sim/step/move_bodies.h"
#include "core/sim/step/stage_timer.h"
#include "core/sim/step/step_error.h"
#include "core/sim/step/strain_rate.h"

namespace loomstone {

namespace {

Traffic between(const Traffic& start, const Traffic& end) {
  return {end.waiting - start.waiting, end.bytes - start.bytes, end.operations - start.operations};
}

StepSpan span_of(double t0, double h) { return {t0, h, t0 + h}; }

// Ratio of the largest step to the shortest step that is tried if contacts create energy. Our
// choice: at 4 m/s, a towel of 3,000 triangles moves by its thickness in 1/64 of the largest step
// of 10 ms, and the shortest step is a quarter of this time.
constexpr double shortest_for_contacts = 256.0;

}  // namespace

Stepper::Stepper(const Model& model, const IntegratorOptions& options, StepChoice steps,
                 const Workers& workers, const State& state)
    : steps_(steps),
      engines_(model, options, workers, state),
      threads_(workers.team.threads, threads_sleep() || !workers.layout.single()) {}

void Stepper::advance(State& state, StepOutcome& outcome) {
  const Communicator& ranks = engines_.layout.communicator();
  const Traffic traffic_before = ranks.traffic();
  RankWork work;
  std::optional<StageTimer> timer(work.wall);
  state.rigid.manifolds.clear();  // manifolds are saved again when needed
  const EnergyAccount before = state.account;
  begin_account(engines_, state);
  outcome.start = state;
  save_to(outcome.start);
  begin_outcome(state.step, engines_.model.cloth.n_vertices, outcome);
  std::fill(engines_.busy.begin(), engines_.busy.end(), 0.0);
  engines_.team.threads = engines_.collision_team.threads = threads_.threads();
  threads_.start();
  try {
    const StepSpan span = take_parts(state, outcome);
    finish(span, state, outcome);
    threads_.stop();
    timer.reset();
    work.traffic = between(traffic_before, ranks.traffic());
    work.collision_computing = outcome.report.ranks.collision_computing;
    work.collision_waiting = outcome.report.ranks.collision_waiting;
    outcome.report.ranks = summary_of(ranks, work);
  } catch (const SolverFailure& failure) {
    return_to_state(outcome.start, state);
    state.account = before;
    std::ostringstream out;
    out << "step " << outcome.report.step << " (from time " << state.time
        << " s) failed: " << failure.what();
    throw SolverFailure(out.str());
  }
}

// Takes the whole step at once or, if this fails, in parts. If the error of an automatic step is
// too large or contacts create energy in it, the whole step is shortened instead, as long as no
// part of it is complete.
StepSpan Stepper::take_parts(State& state, StepOutcome& outcome) {
  StepSpan span = next_span(state);
  Bisection bisection(engines_.limits_in_solve);
  State part_start;
  const State* snapshot = &outcome.start;  // state at the start of the part
  double settled = 0.0;  // length of an automatic step in which contacts created energy [s]
  while (true) {
    if (!steps_.automatic)
      bisection.shorten(expected_part(context(span, bisection.part(), state), state, engines_));
    const StepPart part = bisection.part();
    const OutcomeMark start = mark(outcome);
    const PartResult result = attempt(context(span, part, state), state, outcome);
    if (bisection.judge(result) == Bisection::Verdict::Repeated) {
      return_to_state(*snapshot, state);
      return_to(start, outcome);
      if (steps_.automatic && part.length() == StepPart::whole && result.solved &&
          result.longest < part.length()) {
        double h = span.h * result.longest / StepPart::whole;
        if (result.contacts_gain) {
          settled = std::max(settled, span.h);
          h = std::max(h, steps_.largest / shortest_for_contacts);
        }
        span = span_of(state.time, h);
        bisection = Bisection(engines_.limits_in_solve);
      }
      continue;
    }
    outcome.report.contacts.unresolved += result.impacts;
    ++outcome.report.parts;
    if (bisection.done()) {
      state.cloth.settled_step = std::max(settled, state.cloth.settled_step);
      return span;
    }
    PathPoint end{static_cast<double>(part.last) / StepPart::whole, {}};
    collision_vertices(engines_.model, state, end.vertices);
    outcome.path.push_back(std::move(end));
    part_start = state;
    save_to(part_start);
    snapshot = &part_start;
  }
}

PartResult Stepper::attempt(const StepContext& part, State& state, StepOutcome& outcome) {
  try {
    return run_stages(part, state, outcome);
  } catch (const StepFailure&) {
    if (part.length == StepPart::least) throw;
    PartResult failed;
    failed.solved = false;
    return failed;
  }
}

// Runs a stage of collision handling.
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
  int longest = part.length;
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
  timed(seconds.bodies, [&] {
    solved_.obstacle_work = move_bodies(part, loads_, bodies, state, engines_, report);
  });
  solved_.body_velocity = bodies.velocity;
  note_solved(engines_, state, solved_);
  collide(seconds.certify, report,
          [&] { certified = limit_and_certify(part, loads_, near_, state, engines_, outcome); });
  timed(seconds.limit, [&] {
    after.limited =
        certified.limited + limit_strain_rate(part, certified, state, engines_, outcome);
  });
  timed(seconds.check, [&] {
    if (certified.moved) error = error_of_motion(part, loads_, state, engines_);
    note_error(part, error, engines_, report);
    after.untangles = !near_.tangle.empty(), after.surfaces_move = surfaces_move(loads_);
    add_to_account(work_of_part(part, loads_, near_, solved_, state, engines_), solved_, after,
                   engines_, state);
    longest = length_without_gain(part, loads_, near_, engines_, state);
  });
  if (too_large(part, error, engines_)) return shorter(part, error, engines_);
  if (longest < part.length) return shortened_for_contacts(longest);
  state.cloth.previous_step = part.h;
  expect_part(part, error, engines_, state.cloth);
  return certified.result;
}

void Stepper::finish(const StepSpan& span, State& state, StepOutcome& outcome) {
  StepReport& report = outcome.report;
  report.busy = summary_of(engines_.busy);
  const StageTimer timer(report.seconds.check);
  ++state.step;
  state.time = report.time = span.t1;
  if (steps_.automatic) expect_step(steps_.largest, outcome.start, span.h, engines_, state);
  report.length = span.h;
  check_divergence(engines_.model, loads_.x0, state.cloth, "certify");
  know_contacts(state, engines_);
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

StepSpan Stepper::next_span(const State& state) {
  if (steps_.automatic) return span_of(state.time, automatic_step(steps_.largest, state, engines_));
  // The end of a fixed step is computed from the number of steps, so rounding errors do not
  // accumulate.
  return {state.time, steps_.largest, static_cast<double>(state.step + 1) * steps_.largest};
}

StepContext Stepper::context(const StepSpan& span, StepPart part, const State& state) const {
  const auto time = [&](int place) {
    return place == StepPart::whole ? span.t1 : span.t0 + span.h * place / StepPart::whole;
  };
  StepContext context;
  context.h = span.h * part.length() / StepPart::whole;
  context.t0 = time(part.first);
  context.t1 = time(part.last);
  context.share = static_cast<double>(part.length()) / (StepPart::whole - part.first);
  if (steps_.automatic && state.target_time > context.t0)
    context.share = std::min(1.0, context.h / (state.target_time - context.t0));
  else if (steps_.automatic)
    context.share = 1.0;
  context.length = part.length();
  context.automatic = steps_.automatic;
  context.divisible = part.length() > StepPart::least &&
                      (!steps_.automatic || span.h > steps_.largest / StepPart::whole);
  context.halvable = part.length() > StepPart::least &&
                     (!steps_.automatic || span.h > steps_.largest / shortest_for_contacts);
  context.seed = static_cast<std::uint64_t>(state.step) * StepPart::whole +
                 static_cast<std::uint64_t>(part.first);
  return context;
}

void Stepper::save_to(State& snapshot) const {
  if (engines_.world) engines_.world->save(snapshot.rigid);
}

void Stepper::return_to_state(const State& snapshot, State& state) {
  state = snapshot;
  if (engines_.world) engines_.world->restore(state.rigid);
}

}  // namespace loomstone
