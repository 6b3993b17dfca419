// The threads of one simulation, and its parallel loops. All results are the same for any number of
// threads: each iteration of a loop writes only its own entries, and sums add fixed blocks of rows
// in order.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <exception>
#include <vector>

#include "core/base/types.h"

namespace loomstone {

// Number of rows per block. Sums over rows are computed block by block, and the row ranges of ranks
// start at multiples of this number.
inline constexpr Index rows_per_block = 128;

struct Team {
  int threads = 1;
  std::int64_t* iterations = nullptr;  // counts loop iterations and tests of TaskPool; may be null
  // (threads) Time that each thread works in loops, traversals and tasks [s]; may be null.
  double* busy = nullptr;
};

// Largest number of threads that may be requested. libgomp aborts if it cannot start all of them.
inline constexpr int most_threads = 1024;

// Returns the number of processors available to this process.
int available_processors();

// Returns the number of threads in the environment variable OMP_NUM_THREADS (the first number if it
// is a list), or 0 if the variable is unset, invalid or outside [1, most_threads].
int threads_in_environment();

// Returns threads_in_environment() or, if it is 0, available_processors().
int default_thread_count();

// Returns the index of the calling thread in its parallel region, 0 to threads - 1.
int thread_number();

// Must be called before each parallel region. Throws Unsupported in a forked process if a loop ran
// on several threads before the fork, because libgomp would then hang.
void check_not_forked();

// Timer that adds its lifetime to the busy time of the calling thread.
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

// Stores the first exception of a parallel loop and rethrows it after the loop, because exceptions
// must not leave a parallel region.
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

// Calls body(begin, end) on ranges that cover [0, n) and start at multiples of `grain`. With one
// thread or n <= grain, there is one range. Throws the first exception of body(). Must not be
// nested.
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

// Calls body(i) for every i in [0, n) with dynamic scheduling, for iterations of uneven cost.
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

// Calls body(thread) once on each thread.
template <class Body>
void on_each_thread(const Team& team, Body&& body) {
  if (team.threads <= 1) {
    body(0);
    return;
  }
  check_not_forked();
  FirstFailure failure;
#pragma omp parallel num_threads(team.threads)
  failure.guard([&] { body(thread_number()); });
  failure.rethrow();
}

// Calls body(i) for every i in [0, n).
template <class Body>
void parallel_for(const Team& team, Index n, Body&& body, Index grain = 512) {
  parallel_ranges(team, n, grain, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) body(i);
  });
}

// Returns the sum of term(i) over [0, n). Each block of rows_per_block terms is summed on its own,
// and the block sums are added in order.
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
