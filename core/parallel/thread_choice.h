// How many threads a simulation uses beside other programs. A parallel loop ends when its last
// thread does. If other programs run on the processors, the other threads wait in every loop until
// the system runs that thread again, and many threads are slower than one. Results do not depend on
// the number of threads.
#pragma once

#include <chrono>

namespace loomstone {

// Chooses between one thread and all of them. The choice follows from the share of the time for
// which the calling thread has run: the system has run other programs in the rest of the time.
class ThreadChoice {
 public:
  // `most` is the number of all threads. `fixed`: always choose all.
  ThreadChoice(int most, bool fixed) : most_(most), threads_(most), fixed_(fixed || most <= 1) {}

  int threads() const { return threads_; }

  // The calling thread must call both, at the start and the end of each step.
  void start();
  void stop();

  // Judges a step that took `wall` [s], for `running` [s] of which the calling thread ran.
  void judge(double wall, double running);

 private:
  int most_, threads_;
  bool fixed_;
  double wall_ = 0.0, running_ = 0.0;  // since the last decision [s]
  double on_one_ = 0.0;                // time since all threads were last in use [s]
  double stay_ = 0.0;                  // least time on one thread before all are tried again [s]
  std::chrono::steady_clock::time_point start_;
  double running_at_start_ = 0.0;
};

}  // namespace loomstone
