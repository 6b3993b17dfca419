// Chooses how many threads a simulation uses when other programs run on the same processors. A
// parallel loop ends when its last thread ends. If another program displaces one thread, all other
// threads wait for this thread in every loop, so many threads may be slower than one. Results do
// not depend on the number of threads.
#pragma once

#include <chrono>

namespace loomstone {

// Chooses between one thread and all threads, according to the fraction of time during which the
// calling thread has run. During the rest of the time, other programs have probably run in its
// place.
class ThreadChoice {
 public:
  // `most` is the number of all threads. If `fixed` is set, all threads are always used.
  ThreadChoice(int most, bool fixed) : most_(most), threads_(most), fixed_(fixed || most <= 1) {}

  int threads() const { return threads_; }

  // The thread that steps the simulation must call start() at the start of each step and stop() at
  // its end.
  void start();
  void stop();

  // Accounts for a step that took `wall` [s], of which the calling thread ran for `running` [s].
  // Decides on the number of threads if the steps since the last decision took at least 10 ms.
  void judge(double wall, double running);

 private:
  int most_, threads_;
  bool fixed_;
  double wall_ = 0.0, running_ = 0.0;  // sums of `wall` and `running` since the last decision [s]
  double on_one_ = 0.0;                // duration of all steps since the change to one thread [s]
  double stay_ = 0.0;                  // least time on one thread until all are tried again [s]
  std::chrono::steady_clock::time_point start_;
  double running_at_start_ = 0.0;
};

}  // namespace loomstone
