#include "core/sim/step/parts.h"

#include <algorithm>
#include <optional>

#include "core/base/error.h"
#include "core/sim/model/motion.h"
#include "core/sim/step/step_error.h"

namespace loomstone {

namespace {

// Ratio of the largest to the shortest automatic step that is tried if a step creates too much
// energy. Our choice: at 4 m/s, a towel of 0.18 x 0.12 m with 3,000 triangles moves by 1.4 times
// its thickness in 1/64 of the largest step of 10 ms, but by 0.36 times its thickness in 1/256.
constexpr double shortest_for_gain = 256.0;

// A part is not repeated for losing too much of the work of scripts if its step is at least this
// many times as long as the part, or if its step is automatic and the largest step is at least this
// many times as long as the step. Our choice: shorter parts lose work, too, where a surface strikes
// cloth that is at rest.
constexpr int shortest_for_loss = 16;

StepSpan span_of(double t0, double h) { return {t0, h, t0 + h}; }

StepSpan next_span(const StepChoice& steps, Engines& engines, const State& state) {
  if (steps.automatic) return span_of(state.time, automatic_step(steps.largest, state, engines));
  // The end of a step of given length is computed from the number of steps, so rounding errors do
  // not accumulate.
  return {state.time, steps.largest, static_cast<double>(state.step + 1) * steps.largest};
}

StepContext context_of(const StepSpan& span, StepPart part, const StepChoice& steps,
                       const State& state) {
  const auto time = [&](int place) {
    return place == StepPart::whole ? span.t1 : span.t0 + span.h * place / StepPart::whole;
  };
  StepContext context;
  context.h = span.h * part.length() / StepPart::whole;
  context.t0 = time(part.first);
  context.t1 = time(part.last);
  context.share = static_cast<double>(part.length()) / (StepPart::whole - part.first);
  if (steps.automatic && state.target_time > context.t0)
    context.share = std::min(1.0, context.h / (state.target_time - context.t0));
  else if (steps.automatic)
    context.share = 1.0;
  context.length = part.length();
  context.automatic = steps.automatic;
  context.divisible = part.length() > StepPart::least &&
                      (!steps.automatic || span.h > steps.largest / StepPart::whole);
  context.halvable = part.length() > StepPart::least &&
                     (!steps.automatic || span.h > steps.largest / shortest_for_gain);
  context.saves_work = part.length() > StepPart::whole / shortest_for_loss &&
                       (!steps.automatic || span.h > steps.largest / shortest_for_loss);
  context.seed = static_cast<std::uint64_t>(state.step) * StepPart::whole +
                 static_cast<std::uint64_t>(part.first);
  return context;
}

PartResult attempt(const StepContext& part, const RunPart& run) {
  try {
    return run(part);
  } catch (const StepFailure&) {
    if (part.length == StepPart::least) throw;
    PartResult failed;
    failed.solved = false;
    return failed;
  }
}

}  // namespace

void save_world(const Engines& engines, SteppedState& snapshot) {
  if (engines.world) engines.world->save(snapshot.rigid);
}

void return_to_state(const SteppedState& snapshot, Engines& engines, State& state) {
  static_cast<SteppedState&>(state) = snapshot;
  if (engines.world) engines.world->restore(state.rigid);
}

StepSpan take_parts(const StepChoice& steps, Engines& engines, State& state, StepOutcome& outcome,
                    const RunPart& run) {
  StepSpan span = next_span(steps, engines, state);
  Bisection bisection(engines.limits_in_solve);
  SteppedState part_start;
  const SteppedState* snapshot = &outcome.start;  // state at the start of the part
  // Largest length with which this automatic step created too much energy [s]; 0: none.
  double settled = 0.0;
  while (true) {
    if (!steps.automatic) {
      const StepContext next = context_of(span, bisection.part(), steps, state);
      bisection.shorten(steps.stable > 0.0 ? stable_part(next, steps, engines, state)
                                           : expected_part(next, state, engines));
    }
    const StepPart part = bisection.part();
    const OutcomeMark start = mark(outcome);
    StepContext context = context_of(span, part, steps, state);
    context.start = snapshot;
    const PartResult result = attempt(context, run);
    if (bisection.judge(result) == Bisection::Verdict::Repeated) {
      return_to_state(*snapshot, engines, state);
      return_to(start, outcome);
      if (steps.automatic && part.length() == StepPart::whole && result.solved &&
          result.longest < part.length()) {
        double h = span.h * result.longest / StepPart::whole;
        if (result.gains_energy) {
          settled = std::max(settled, span.h);
          h = std::max(h, steps.largest / shortest_for_gain);
        }
        span = span_of(state.time, h);
        bisection = Bisection(engines.limits_in_solve);
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
    collision_vertices(engines.model, state, end.vertices);
    outcome.path.push_back(std::move(end));
    part_start = state;
    save_world(engines, part_start);
    snapshot = &part_start;
  }
}

}  // namespace loomstone
