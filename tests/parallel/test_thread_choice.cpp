#include <catch2/catch.hpp>

#include "core/parallel/thread_choice.h"

using loomstone::ThreadChoice;

TEST_CASE("all threads are used while the calling thread runs without interruption") {
  ThreadChoice choice(4, false);
  for (int step = 0; step < 100; ++step) {
    CHECK(choice.threads() == 4);
    choice.judge(0.02, 0.0195);
  }
}

TEST_CASE("one thread is used beside other programs, and all of them are tried again later") {
  ThreadChoice choice(4, false);
  choice.judge(0.02, 0.01);
  CHECK(choice.threads() == 1);
  // One thread remains the choice as long as other programs displace the calling thread.
  for (int step = 0; step < 100; ++step) choice.judge(0.02, 0.012);
  CHECK(choice.threads() == 1);
  choice.judge(0.02, 0.02);
  CHECK(choice.threads() == 4);
  // Each failed trial of all threads doubles the minimum time until the next trial.
  const auto steps_on_one = [&] {
    choice.judge(0.02, 0.01);
    int steps = 0;
    while (choice.threads() == 1) choice.judge(0.02, 0.02), ++steps;
    return steps;
  };
  const int second = steps_on_one(), third = steps_on_one();
  CHECK(second >= 10);
  CHECK(third == Approx(2 * second).margin(2));
  for (int trial = 0; trial < 10; ++trial) steps_on_one();
  CHECK(steps_on_one() == Approx(500).margin(2));  // the minimum time grows to at most 10 s
  // A successful trial resets the minimum time.
  choice.judge(0.02, 0.02);
  CHECK(steps_on_one() <= 6);
}

TEST_CASE("short steps are judged together, and a fixed choice never changes") {
  ThreadChoice choice(2, false);
  choice.judge(0.002, 0.0005);
  CHECK(choice.threads() == 2);
  for (int step = 0; step < 5; ++step) choice.judge(0.002, 0.0005);
  CHECK(choice.threads() == 1);
  ThreadChoice fixed(2, true);
  fixed.judge(1.0, 0.1);
  CHECK(fixed.threads() == 2);
}
