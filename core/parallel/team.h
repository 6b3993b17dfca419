// The threads of one simulation and the loops that run on them. The result of every helper is the
// same for any number of threads: a loop writes only to slots its index owns; a sum adds fixed
// blocks of rows in order.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <exception>
#include <vector>

#include "core/base/types.h"

namespace loomstone {

// Rows that are summed together before block sums are added in order; cuts between ranks fall on
// multiples of it.
inline constexpr Index rows_per_block = 128;

struct Team {
  int threads = 1;
  std::int64_t* iterations = nullptr;  // counts the loops' iterations, where somebody wants to know
  double* busy = nullptr;              // (threads) seconds that each spends inside loops, likewise
};

// Number of threads to use when the user asks for none (processors this process may run on).
int default_thread_count();

// Throws Unsupported when called in a process forked after a parallel loop has run (libgomp would
// hang).
void check_not_forked();

// Adds the time of its life to the calling thread's.
class BusyTimer {
 public:
  explicit BusyTimer(const Team& team);
  ~BusyTimer();
  BusyTimer(const BusyTimer&) = delete;
  BusyTimer& operator=(const BusyTimer&) = delete;

 private:
  double* seconds_;
  std::chrono::steady_clock::time_point start_;
};

// Keeps the first exception of a parallel loop, which must not leave its thread, and throws it
// after the loop.
class FirstFailure {
 public:
  template <class Work>
  void guard(Work&& work) {
    try {
      work();
    } catch (...) {
#pragma omp critical(loomstone_failure)
      if (!failure_) failure_ = std::current_exception();
    }
  }
  void rethrow() const {
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  std::exception_ptr failure_;
};

// Calls body(begin, end) on ranges that cover [0, n). Ranges start at multiples of `grain`. Serial
// when n <= grain. The first exception is carried out of the loop. Do not nest.
template <class Body>
void parallel_ranges(const Team& team, Index n, Index grain, Body&& body) {
  if (team.iterations) *team.iterations += n;
  const Index n_ranges = (n + grain - 1) / grain;
  if (team.threads <= 1 || n_ranges <= 1) {
    const BusyTimer timer(team);
    if (n > 0) body(Index{0}, n);
    return;
  }
  check_not_forked();
  FirstFailure failure;
#pragma omp parallel num_threads(team.threads)
  {
    const BusyTimer timer(team);
#pragma omp for schedule(static) nowait
    for (Index range = 0; range < n_ranges; ++range) {
      const Index begin = range * grain;
      failure.guard([&] { body(begin, std::min<Index>(n, begin + grain)); });
    }
  }
  failure.rethrow();
}

// Calls body(i) for every i of [0, n), each a task of its own that an idle thread takes: for work
// of uneven size.
template <class Body>
void parallel_tasks(const Team& team, Index n, Body&& body) {
  if (team.iterations) *team.iterations += n;
  if (team.threads <= 1 || n <= 1) {
    const BusyTimer timer(team);
    for (Index i = 0; i < n; ++i) body(i);
    return;
  }
  check_not_forked();
  FirstFailure failure;
#pragma omp parallel num_threads(team.threads)
  {
    const BusyTimer timer(team);
#pragma omp for schedule(dynamic, 1) nowait
    for (Index i = 0; i < n; ++i) failure.guard([&] { body(i); });
  }
  failure.rethrow();
}

// Calls body(i) for every i of [0, n).
template <class Body>
void parallel_for(const Team& team, Index n, Body&& body, Index grain = 512) {
  parallel_ranges(team, n, grain, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) body(i);
  });
}

// Sum over [0, n) of term(i): blocks of `rows_per_block` rows, block sums added in order.
template <class Term>
double parallel_sum(const Team& team, Index n, Term&& term) {
  const Index n_blocks = (n + rows_per_block - 1) / rows_per_block;
  std::vector<double> sums(n_blocks);
  parallel_for(
      team, n_blocks,
      [&](Index block) {
        const Index end = std::min<Index>(n, (block + 1) * rows_per_block);
        double sum = 0.0;
        for (Index i = block * rows_per_block; i < end; ++i) sum += term(i);
        sums[block] = sum;
      },
      8);
  double total = 0.0;
  for (const double sum : sums) total += sum;
  return total;
}

}  // namespace loomstone
