// How a thread waits for other ranks or threads. It polls for a while, and then sleeps between
// polls. Sleeps become longer with the wait, so a wait ends at most about a quarter too late. A
// thread that yields its processor beside other busy programs loses it for a whole time slice,
// which is several milliseconds. Linux wakes a thread that sleeps at the end of its sleep.
//
// If there are more ranks than processors, threads yield before they sleep, because another rank
// then continues within microseconds.
#pragma once

#include <chrono>

namespace loomstone {

using WaitTime = std::chrono::duration<double, std::micro>;

// Time for which a thread polls before it sleeps: that of the environment variable
// LOOMSTONE_MPI_SPIN [us] when the process first asks for it, or 100 us. Negative if the variable
// is not a number >= 0.
WaitTime polling_time();

// What a thread does between two polls.
struct Rest {
  enum class Kind { None, Yield, Sleep } kind = Kind::None;
  WaitTime length{0.0};  // of a sleep
};
// Returns what to do in a wait that has lasted for `waited`. shared: there are more ranks than
// processors.
Rest rest_after(WaitTime waited, WaitTime polling, bool shared);

// Must be called if there are more ranks than processors.
void share_processors();

// The wait of one thread for one event.
class Patience {
 public:
  Patience() = default;
  ~Patience() { reset(); }
  Patience(const Patience&) = delete;
  Patience& operator=(const Patience&) = delete;

  // Must be called after each poll that finds nothing.
  void wait();
  // Must be called when the event has happened and the thread will wait for another one.
  void reset();

 private:
  using Clock = std::chrono::steady_clock;

  bool waits_ = false;
  Clock::time_point start_;
  int slack_ = 0;  // timer slack of the thread before its first sleep [ns]; 0 if it has not slept
};

}  // namespace loomstone
