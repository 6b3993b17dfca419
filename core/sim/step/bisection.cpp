#include "core/sim/step/bisection.h"

namespace loomstone {

void Bisection::shorten(int longest) {
  const StepPart part = left_.back();
  const int n = (part.length() + longest - 1) / longest;
  if (n <= 1) return;
  const int end = part.first + part.length() / n;
  left_.back() = {end, part.last};
  left_.push_back({part.first, end});
}

Bisection::Verdict Bisection::judge(const PartResult& result) {
  const StepPart part = left_.back();
  if (result.longest < part.length()) {
    shorten(result.longest);
    return Verdict::Repeated;
  }
  left_.pop_back();
  const auto halves = [&](bool failed, Answer answer, int least) {
    return failed && answer == Answer::Halve && part.length() > least;
  };
  const bool limits = result.broke_limits || result.stopped_for_limits;
  // If only sweeps enforce the limits, and fallbacks have withheld at most 1 % of the motion, parts
  // shorter than a quarter of the step are not worth their cost. The remaining excess is reported.
  const bool worth = result.stopped_for_limits || limits_in_solve_;
  const int least_for_limits = worth ? StepPart::least : StepPart::quarter;
  if (!result.solved || halves(result.impacts > 0, impacts_, StepPart::least) ||
      halves(limits, limits_, least_for_limits) ||
      halves(result.withheld_much, withheld_, StepPart::quarter)) {
    const int middle = part.first + part.length() / 2;
    left_.push_back({middle, part.last});
    left_.push_back({part.first, middle});
    return Verdict::Repeated;
  }
  if (result.impacts > 0) impacts_ = Answer::Accept;
  if (limits) limits_ = Answer::Accept;
  if (result.withheld_much) withheld_ = Answer::Accept;
  return Verdict::Accepted;
}

}  // namespace loomstone
