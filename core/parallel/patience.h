// Waits of a thread for other ranks or threads. The thread polls for a while, and then sleeps
// between polls. The sleeps grow with the time waited, up to a limit, so sleeping prolongs a wait
// by at most about a quarter of its length, or 20 us if that is more. While other programs are
// busy, a thread that yields its processor loses it for a whole time slice of several milliseconds.
// In contrast, Linux wakes a sleeping thread at the end of its sleep.
//
// If there are more ranks than processors, threads yield before they sleep, because another rank
// then continues within microseconds.
#pragma once

#include <chrono>

namespace loomstone {

using WaitTime = std::chrono::duration<double, std::micro>;

// Returns the time for which a thread polls before it sleeps. It is the value of the environment
// variable LOOMSTONE_MPI_SPIN [us] at the first call, or 100 us if the variable is unset or empty.
// If the variable has a value that is not a finite number >= 0, the result is negative.
WaitTime polling_time();

// Action of a thread between two polls.
struct Rest {
  enum class Kind { None, Yield, Sleep } kind = Kind::None;
  WaitTime length{0.0};  // length of the sleep; 0 for the other kinds
};
// Returns what to do in a wait that has lasted for `waited`, if threads poll for the time `polling`
// before they sleep. `shared` tells whether there are more ranks than processors.
Rest rest_after(WaitTime waited, WaitTime polling, bool shared);

// Lets waiting threads yield before they sleep. Must be called if there are more ranks than
// processors. The MPI plug-in contains its own copy of patience.cpp, so the plug-in and its loader
// both call this function.
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
  int slack_ = 0;  // timer slack before the first sleep of this wait [ns]; 0 if there was no sleep
};

}  // namespace loomstone
