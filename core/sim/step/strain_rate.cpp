#include "core/sim/step/strain_rate.h"

namespace loomstone {

void limit_strain_rate(const StepContext& part, const Certified& certified, State& state,
                       Engines& engines, StepOutcome& outcome) {
  if (!engines.limiter) return;
  StrainLimiter& limiter = *engines.limiter;
  const LimitReport left =
      certified.limits ? *certified.limits : limiter.measure(engines.team, state.cloth.x);
  StepReport& report = outcome.report;
  report.weft_excess = left.excess[0];
  report.warp_excess = left.excess[1];
  report.shear_excess = left.excess[2];
  report.beyond_limit = left.beyond;
  report.worst_element = left.worst < 0 ? -1 : engines.model.triangle_of[left.worst];
  outcome.broken = left.broken;
  report.broken_limits = static_cast<std::int64_t>(left.broken_elements().size());
  report.rate_sweeps +=
      limiter.enforce_rate(engines.team, part.seed, state.cloth.x, part.h, state.cloth.v, false)
          .sweeps;
}

}  // namespace loomstone
