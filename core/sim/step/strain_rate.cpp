#include "core/sim/step/strain_rate.h"

#include <algorithm>

#include "core/sim/step/energies.h"

namespace loomstone {

double limit_strain_rate(const StepContext& part, const Certified& certified, Solved& solved,
                         State& state, Engines& engines, StepOutcome& outcome) {
  if (!engines.limiter) return 0.0;
  StrainLimiter& limiter = *engines.limiter;
  const LimitReport left =
      certified.limits ? *certified.limits : limiter.measure(engines.team, state.cloth.x);
  StepReport& report = outcome.report;
  report.limits.excess = std::max(report.limits.excess, left.largest());
  report.limits.weft_excess = left.excess[0];
  report.limits.warp_excess = left.excess[1];
  report.limits.shear_excess = left.excess[2];
  report.limits.beyond = left.beyond;
  report.limits.worst_element = left.worst < 0 ? -1 : engines.model.triangle_of[left.worst];
  outcome.broken = left.broken;
  report.limits.broken = static_cast<std::int64_t>(left.broken_elements().size());
  if (!engines.limits_after_solve) return 0.0;
  solved.keep(state.cloth);
  const Points before = state.cloth.v;
  report.limits.rate_sweeps +=
      limiter.enforce_rate(engines.team, part.seed, state.cloth.x, part.h, state.cloth.v, false)
          .sweeps;
  if (state.cloth.v == before) return 0.0;
  return kinetic_energy(engines, before) - kinetic_energy(engines, state.cloth.v);
}

}  // namespace loomstone
