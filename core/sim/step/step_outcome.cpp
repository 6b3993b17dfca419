#include "core/sim/step/step_outcome.h"

#include <algorithm>
#include <numeric>

namespace loomstone {

void begin_outcome(std::int64_t step, Index n_vertices, StepOutcome& outcome) {
  StepReport& report = outcome.report;
  report = StepReport{};
  report.step = step + 1;
  report.parts = 0;
  outcome.contact.assign(n_vertices, 0);
  outcome.path.clear();
  outcome.forced.clear();
  outcome.broken.clear();
}

ThreadReport summary_of(const std::vector<double>& busy) {
  const double sum = std::accumulate(busy.begin(), busy.end(), 0.0);
  return {*std::min_element(busy.begin(), busy.end()), sum / static_cast<double>(busy.size()),
          *std::max_element(busy.begin(), busy.end())};
}

void return_to(const OutcomeMark& mark, StepOutcome& outcome) {
  const StepReport spent = outcome.report;
  StepReport& report = outcome.report;
  report = mark.report;
  report.seconds = spent.seconds;
  report.solver.newton_iterations = spent.solver.newton_iterations;
  report.solver.linear_iterations = spent.solver.linear_iterations;
  report.limits.sweeps = spent.limits.sweeps;
  report.limits.evaluations = spent.limits.evaluations;
  report.limits.rate_sweeps = spent.limits.rate_sweeps;
  report.limits.rounds = spent.limits.rounds;
  report.limits.fallbacks = spent.limits.fallbacks;
  outcome.contact = mark.contact;
}

}  // namespace loomstone
