#include "core/sim/step/step_outcome.h"

namespace loomstone {

void begin_outcome(std::int64_t step, double step_length, Index n_vertices, StepOutcome& outcome) {
  StepReport& report = outcome.report;
  report = StepReport{};
  report.step = step + 1;
  report.time = static_cast<double>(step + 1) * step_length;
  report.substeps = 0;
  outcome.contact.assign(n_vertices, 0);
  outcome.forced.clear();
  outcome.broken.clear();
}

void return_to(const OutcomeMark& mark, StepOutcome& outcome) {
  const StepReport spent = outcome.report;
  StepReport& report = outcome.report;
  report = mark.report;
  report.seconds = spent.seconds;
  report.newton_iterations = spent.newton_iterations;
  report.linear_iterations = spent.linear_iterations;
  report.limit_sweeps = spent.limit_sweeps;
  report.limit_evaluations = spent.limit_evaluations;
  report.rate_sweeps = spent.rate_sweeps;
  report.limit_rounds = spent.limit_rounds;
  report.limit_retreats = spent.limit_retreats;
  outcome.contact = mark.contact;
}

}  // namespace loomstone
