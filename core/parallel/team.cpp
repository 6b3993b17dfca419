// Default number of threads, detection of forks, timing of threads, and suppression of nested
// parallel regions.
#include "core/parallel/team.h"

#include <atomic>
#include <cstdlib>

#include <omp.h>
#include <pthread.h>
#include <sched.h>

#include "core/base/error.h"
#include "core/parallel/nested_regions.h"

namespace loomstone {

namespace {

std::atomic<bool> region_has_run{false};
std::atomic<bool> forked_after_region{false};

// The threads of libgomp do not survive a fork. The first parallel region of the child process
// would wait for them forever.
void in_forked_child() {
  if (region_has_run.load(std::memory_order_relaxed))
    forked_after_region.store(true, std::memory_order_relaxed);
}

}  // namespace

int available_processors() {
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  if (sched_getaffinity(0, sizeof allowed, &allowed) == 0 && CPU_COUNT(&allowed) > 0)
    return CPU_COUNT(&allowed);
  return std::max(1, omp_get_num_procs());
}

int threads_in_environment() {
  const char* text = std::getenv("OMP_NUM_THREADS");
  if (text == nullptr) return 0;
  char* end = nullptr;
  const long number = std::strtol(text, &end, 10);
  while (*end == ' ') ++end;
  return (*end == '\0' || *end == ',') && number >= 1 && number <= most_threads
             ? static_cast<int>(number)
             : 0;
}

int default_thread_count() {
  const int given = threads_in_environment();
  return given > 0 ? given : available_processors();
}

int thread_number() { return omp_get_thread_num(); }

void check_not_forked() {
  if (!region_has_run.load(std::memory_order_relaxed)) {
    static const int registered = pthread_atfork(nullptr, nullptr, in_forked_child);
    static_cast<void>(registered);
    region_has_run.store(true, std::memory_order_relaxed);
  }
  if (forked_after_region.load(std::memory_order_relaxed))
    throw Unsupported(
        "a forked process cannot run parallel loops, got a fork after the parent had run one; "
        "start processes with the method \"spawn\", or use threads=1");
}

BusyTimer::BusyTimer(const Team& team)
    : seconds_(team.busy ? team.busy + omp_get_thread_num() : nullptr) {
  if (seconds_) start_ = std::chrono::steady_clock::now();
}

BusyTimer::~BusyTimer() {
  if (seconds_)
    *seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

NoNestedRegions::NoNestedRegions() : levels_(omp_get_max_active_levels()) {
  omp_set_max_active_levels(0);
}
NoNestedRegions::~NoNestedRegions() { omp_set_max_active_levels(levels_); }

}  // namespace loomstone
