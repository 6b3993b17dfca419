// Tests of how a failing step is taken in parts.
#include <catch2/catch.hpp>

#include "core/sim/step/bisection.h"

using namespace loomstone;

namespace {

PartResult unsolved() {
  PartResult result;
  result.solved = false;
  return result;
}

PartResult with_impacts() {
  PartResult result;
  result.impacts = 3;
  return result;
}

// Lengths of the accepted parts [1/64 of the step]. `result` returns the outcome of an attempt at a
// part.
template <class Result>
std::vector<int> accepted(bool limits_in_solve, Result&& result) {
  Bisection bisection(limits_in_solve);
  std::vector<int> lengths;
  int place = 0;
  while (!bisection.done()) {
    const StepPart part = bisection.part();
    REQUIRE(part.first == place);  // parts follow each other without a gap
    if (bisection.judge(result(part)) == Bisection::Verdict::Repeated) continue;
    lengths.push_back(part.length());
    place = part.last;
  }
  CHECK(place == StepPart::whole);
  return lengths;
}

}  // namespace

TEST_CASE("a step that succeeds is taken whole") {
  CHECK(accepted(true, [](StepPart) { return PartResult{}; }) == std::vector<int>{64});
}

TEST_CASE("parts in which the solver fails are halved, and cover the step once in order") {
  const std::vector<int> lengths = accepted(true, [](StepPart part) {
    return part.length() > 4 && part.first < 8 ? unsolved() : PartResult{};
  });
  CHECK(lengths == std::vector<int>{4, 4, 8, 16, 32});
}

TEST_CASE(
    "impacts halve parts down to the least length; then all parts with impacts are accepted") {
  const std::vector<int> lengths = accepted(true, [](StepPart) { return with_impacts(); });
  CHECK(lengths == std::vector<int>{1, 1, 2, 4, 8, 16, 32});
}

TEST_CASE("a solver that fails halves parts after impacts have been accepted") {
  const std::vector<int> lengths = accepted(true, [](StepPart part) {
    return part.first == 32 && part.length() == 32 ? unsolved() : with_impacts();
  });
  CHECK(lengths == std::vector<int>{1, 1, 2, 4, 8, 16, 16, 16});
}

TEST_CASE("broken limits halve down to quarters where sweeps alone limit, further in the solve") {
  const auto broken = [](StepPart) {
    PartResult result;
    result.broke_limits = true;
    return result;
  };
  CHECK(accepted(false, broken) == std::vector<int>{16, 16, 32});
  CHECK(accepted(true, broken) == std::vector<int>{1, 1, 2, 4, 8, 16, 32});
}

TEST_CASE("cloth stopped by its limits halves parts, with limits in the solve or not") {
  const auto stopped = [](StepPart) {
    PartResult result;
    result.stopped_for_limits = true;
    return result;
  };
  CHECK(accepted(false, stopped) == accepted(true, stopped));
  CHECK(accepted(false, stopped).front() == StepPart::least);
}

TEST_CASE("motion withheld in large part halves down to quarters") {
  const auto withheld = [](StepPart) {
    PartResult result;
    result.withheld_much = true;
    return result;
  };
  CHECK(accepted(true, withheld) == std::vector<int>{16, 16, 32});
}

TEST_CASE("a part whose error is too large is repeated in equal parts that the error allows") {
  const auto inaccurate = [](int longest) {
    return [longest](StepPart) {
      PartResult result;
      result.longest = longest;
      return result;
    };
  };
  CHECK(accepted(true, inaccurate(30)) == std::vector<int>{21, 21, 22});
  CHECK(accepted(true, inaccurate(63)) == std::vector<int>{32, 32});
  CHECK(accepted(true, inaccurate(1)) == std::vector<int>(64, 1));
}

TEST_CASE("the next part is shortened before an attempt") {
  Bisection bisection(true);
  bisection.shorten(16);
  CHECK(bisection.part().length() == 16);
  CHECK(bisection.judge({}) == Bisection::Verdict::Accepted);
  CHECK(bisection.part().length() == 48);
  bisection.shorten(64);
  CHECK(bisection.part().length() == 48);
}
