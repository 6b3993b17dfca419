#include "core/collision/broad_phase/record_tests.h"

#include <algorithm>
#include <chrono>
#include <limits>

namespace loomstone {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_between(Clock::time_point start, Clock::time_point end) {
  return std::chrono::duration<double>(end - start).count();
}

struct Numbered {
  NodeTest test;
  Index number;
};

// Performs the tests of one search, numbers them and measures their costs.
class Recorder {
 public:
  Recorder(const TaskPool::Perform& perform, RecordedTests& tests)
      : perform_(perform), tests_(tests), again_(tests.size() > 0), clock_(clock_seconds()) {}

  Index add() {
    if (!again_) {
      tests_.first_child.push_back(0);
      tests_.n_children.push_back(0);
      tests_.seconds.push_back(std::numeric_limits<double>::infinity());
    }
    return n_++;
  }
  void traverse(const NodeTest& root, Index number) {
    stack_.push_back({root, number});
    while (!stack_.empty()) {
      const Numbered next = stack_.back();
      stack_.pop_back();
      children_.clear();
      const auto start = Clock::now();
      perform_(0, next.test, children_);
      const double cost = std::max(0.0, seconds_between(start, Clock::now()) - clock_);
      tests_.seconds[next.number] = std::min(tests_.seconds[next.number], cost);
      tests_.first_child[next.number] = n_;
      tests_.n_children[next.number] = static_cast<Index>(children_.size());
      for (const NodeTest& child : children_) stack_.push_back({child, add()});
    }
  }

 private:
  const TaskPool::Perform& perform_;
  RecordedTests& tests_;
  const bool again_;
  const double clock_;
  Index n_ = 0;
  std::vector<Numbered> stack_;
  std::vector<NodeTest> children_;
};

}  // namespace

void record_tests(const FirstTests& first_tests, int n_ranks, const TaskPool::Perform& perform,
                  RecordedTests& tests) {
  Recorder recorder(perform, tests);
  tests.roots.resize(n_ranks);
  tests.start.resize(n_ranks, std::numeric_limits<double>::infinity());
  for (int rank = 0; rank < n_ranks; ++rank) {
    const auto start = Clock::now();
    const std::vector<NodeTest> roots = first_tests(rank);
    tests.start[rank] = std::min(tests.start[rank], seconds_between(start, Clock::now()));
    tests.roots[rank].clear();
    for (const NodeTest& root : roots) {
      tests.roots[rank].push_back(recorder.add());
      recorder.traverse(root, tests.roots[rank].back());
    }
  }
}

}  // namespace loomstone
