#include "core/sim/step/step_outcome.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/parallel/shared_work.h"

namespace loomstone {

StepOutcome begin_outcome(std::int64_t step, Index n_vertices, StepOutcome& outcome) {
  StepOutcome previous;
  previous.report = outcome.report;
  previous.contact = outcome.contact;
  previous.forced.swap(outcome.forced);
  previous.broken.swap(outcome.broken);
  StepReport& report = outcome.report;
  report = StepReport{};
  report.step = step + 1;
  report.parts = 0;
  outcome.contact.assign(n_vertices, 0);
  outcome.path.clear();
  return previous;
}

void end_failed(StepOutcome previous, StepOutcome& outcome) {
  previous.start = std::move(outcome.start);
  outcome = std::move(previous);
}

RankWork work_of_step(const Communicator& ranks, const Traffic& before, double wall,
                      const RankReport& report) {
  const Traffic after = ranks.traffic();
  return {wall,
          report.collision_computing,
          report.collision_waiting,
          {after.waiting - before.waiting, after.bytes - before.bytes,
           after.operations - before.operations}};
}

RankReport summary_of(const Communicator& ranks, const RankWork& own) {
  const std::vector<RankWork> all = results_of_ranks(ranks, [&] { return own; });
  RankReport report;
  std::int64_t bytes = 0;
  for (const RankWork& rank : all) {
    const double computing = rank.wall - rank.traffic.waiting;
    report.computing += computing / ranks.size();
    report.waiting += rank.traffic.waiting / ranks.size();
    report.collision_computing += rank.collision_computing / ranks.size();
    report.collision_waiting += rank.collision_waiting / ranks.size();
    report.most_computing = std::max(report.most_computing, computing);
    report.most_waiting = std::max(report.most_waiting, rank.traffic.waiting);
    bytes += rank.traffic.bytes;
  }
  report.bytes = bytes / ranks.size();
  report.operations = own.traffic.operations;
  return report;
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
  report.ranks = spent.ranks;
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
