// Traversal of trees by OpenMP tasks, which idle threads take from busy ones.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "core/parallel/team.h"

namespace loomstone {

namespace detail {

template <class Entry, class Visit>
struct Traversal {
  // If a stack has more entries than this, the `most` / 2 entries at its bottom become a new task.
  static constexpr std::size_t most = 16;

  Visit& visit;
  FirstFailure& failure;

  void start(std::vector<Entry> entries) {
    const auto own = std::make_shared<std::vector<Entry>>(std::move(entries));
#pragma omp task firstprivate(own)
    failure.guard([&] { run(*own); });
  }

  void run(std::vector<Entry>& stack) {
    while (!stack.empty()) {
      const Entry entry = stack.back();
      stack.pop_back();
      visit(thread_number(), entry, stack);
      if (stack.size() <= most) continue;
      const auto half = stack.begin() + static_cast<std::ptrdiff_t>(most / 2);
      start({stack.begin(), half});
      stack.erase(stack.begin(), half);
    }
  }
};

}  // namespace detail

// Calls visit(thread, entry, stack) for all `entries` and for all entries that visit() appends to
// `stack`. `thread` is the index of the calling thread. With several threads, the order and the
// threads of the calls differ from run to run. Throws the first exception of visit(). Calls of
// parallel_traverse() must not be nested.
template <class Entry, class Visit>
void parallel_traverse(const Team& team, std::vector<Entry> entries, Visit&& visit) {
  if (team.threads <= 1) {
    const BusyTimer timer(team);
    while (!entries.empty()) {
      const Entry entry = entries.back();
      entries.pop_back();
      visit(0, entry, entries);
    }
    return;
  }
  check_not_forked();
  FirstFailure failure;
  detail::Traversal<Entry, Visit> traversal{visit, failure};
#pragma omp parallel num_threads(team.threads)
  {
    const BusyTimer timer(team);
#pragma omp single
    for (std::size_t begin = 0; begin < entries.size(); begin += 4) {
      const auto first = entries.begin() + static_cast<std::ptrdiff_t>(begin);
      const std::size_t n = std::min<std::size_t>(4, entries.size() - begin);
      traversal.start({first, first + static_cast<std::ptrdiff_t>(n)});
    }
  }
  failure.rethrow();
}

}  // namespace loomstone
