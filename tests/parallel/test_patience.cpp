#include <catch2/catch.hpp>

#include <sys/prctl.h>

#include "core/parallel/patience.h"

using namespace loomstone;

TEST_CASE("a wait polls first, then sleeps for a quarter of its time, within bounds") {
  const auto sleep = [](double waited, double polling) {
    const Rest rest = rest_after(WaitTime{waited}, WaitTime{polling}, false);
    CHECK((rest.kind == Rest::Kind::Sleep) == (rest.length.count() > 0.0));
    return rest.length.count();
  };
  CHECK(sleep(0.0, 100.0) == 0.0);
  CHECK(sleep(99.0, 100.0) == 0.0);
  CHECK(sleep(100.0, 100.0) == 25.0);
  CHECK(sleep(400.0, 100.0) == 100.0);
  CHECK(sleep(1e7, 100.0) == 200.0);
  CHECK(sleep(0.0, 0.0) == 20.0);
  CHECK(sleep(1e7, 1e9) == 0.0);
}

TEST_CASE("a wait on a shared processor yields for a millisecond and then sleeps") {
  CHECK(rest_after(WaitTime{0.0}, WaitTime{100.0}, true).kind == Rest::Kind::Yield);
  CHECK(rest_after(WaitTime{999.0}, WaitTime{100.0}, true).kind == Rest::Kind::Yield);
  CHECK(rest_after(WaitTime{1000.0}, WaitTime{100.0}, true).length.count() == 200.0);
}

TEST_CASE("after a wait, the thread has its timer slack back") {
  const int slack = prctl(PR_GET_TIMERSLACK);
  Patience patience;
  for (int wait = 0; wait < 2; ++wait) {
    while (prctl(PR_GET_TIMERSLACK) == slack) patience.wait();  // loops until the first sleep
    CHECK(prctl(PR_GET_TIMERSLACK) == 1);
    patience.reset();
    CHECK(prctl(PR_GET_TIMERSLACK) == slack);
  }
}
