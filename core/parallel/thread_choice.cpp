#include "core/parallel/thread_choice.h"

#include <algorithm>
#include <ctime>

namespace loomstone {

namespace {

// Thresholds for the fraction of time during which the calling thread runs. On otherwise idle
// processors, this fraction is close to 1. Below `disturbed`, other programs probably interfere,
// and one thread is used. If the fraction then reaches `undisturbed`, all threads are tried again,
// but not before a minimum time.
constexpr double disturbed = 0.8, undisturbed = 0.95;
constexpr double least_window = 10e-3;  // length of the shortest reliable measurement [s]
// Limits of the minimum time on one thread before all threads are tried again [s]. This time
// doubles with every failed trial, because steps of a failed trial can take several times as long
// as on one thread.
constexpr double shortest_stay = 0.1, longest_stay = 10.0;

double running_time() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace

void ThreadChoice::start() {
  if (fixed_) return;
  start_ = std::chrono::steady_clock::now();
  running_at_start_ = running_time();
}

void ThreadChoice::stop() {
  if (fixed_) return;
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start_;
  judge(wall.count(), running_time() - running_at_start_);
}

void ThreadChoice::judge(double wall, double running) {
  if (fixed_) return;
  wall_ += wall, running_ += running;
  if (threads_ == 1) on_one_ += wall;
  if (wall_ < least_window) return;
  const double share = running_ / wall_;
  wall_ = running_ = 0.0;
  if (threads_ == most_) {
    if (share >= disturbed) {
      stay_ = 0.0;
      return;
    }
    stay_ = std::clamp(2.0 * stay_, shortest_stay, longest_stay);
    on_one_ = 0.0;
    threads_ = 1;
  } else if (on_one_ >= stay_ && share >= undisturbed) {
    threads_ = most_;
  }
}

}  // namespace loomstone
