#include "core/parallel/patience.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <thread>

#include <sys/prctl.h>

namespace loomstone {

namespace {

// Polling time if LOOMSTONE_MPI_SPIN is unset or empty [us]. Our choice, meant to exceed the waits
// within a linear solve if each rank has its own processor.
constexpr WaitTime default_polling{100.0};
// Shortest sleep [us]. Our choice: waking up takes tens of microseconds, so shorter sleeps would
// save little processor time.
constexpr WaitTime shortest_sleep{20.0};
// Longest sleep [us]. Our choice: with sleeps of this length, a long wait, for example for a file
// of another rank, takes little processor time.
constexpr WaitTime longest_sleep{200.0};
constexpr double sleep_share = 0.25;  // length of a sleep, as a fraction of the time waited
// If ranks share processors, a thread yields between polls until its wait has lasted for this time
// [us]. Our choice, meant to exceed the waits for the next message of a linear solve.
constexpr WaitTime longest_yielding{1000.0};

std::atomic<bool> processors_are_shared = false;

WaitTime given_polling_time() {
  const char* text = std::getenv("LOOMSTONE_MPI_SPIN");
  if (text == nullptr || *text == '\0') return default_polling;
  char* end = nullptr;
  const double time = std::strtod(text, &end);
  return WaitTime{*end == '\0' && std::isfinite(time) && time >= 0.0 ? time : -1.0};
}

}  // namespace

WaitTime polling_time() {
  static const WaitTime time = given_polling_time();
  return time;
}

Rest rest_after(WaitTime waited, WaitTime polling, bool shared) {
  if (shared && waited < longest_yielding) return {Rest::Kind::Yield};
  if (waited < polling) return {};
  return {Rest::Kind::Sleep, std::clamp(sleep_share * waited, shortest_sleep, longest_sleep)};
}

void share_processors() { processors_are_shared = true; }

void Patience::wait() {
  const Clock::time_point now = Clock::now();
  if (!waits_) start_ = now;
  waits_ = true;
  const Rest rest = rest_after(now - start_, polling_time(), processors_are_shared);
  if (rest.kind == Rest::Kind::Yield) std::this_thread::yield();
  if (rest.kind != Rest::Kind::Sleep) return;
  if (slack_ == 0) {
    // By default, Linux prolongs each sleep by up to 50 us. A timer slack of 1 ns avoids this.
    slack_ = prctl(PR_GET_TIMERSLACK);
    prctl(PR_SET_TIMERSLACK, 1);
  }
  std::this_thread::sleep_for(rest.length);
}

void Patience::reset() {
  if (slack_ > 0) prctl(PR_SET_TIMERSLACK, slack_);
  slack_ = 0;
  waits_ = false;
}

}  // namespace loomstone
