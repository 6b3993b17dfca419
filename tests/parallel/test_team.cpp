#include <catch2/catch.hpp>

#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <string>

#include "core/base/error.h"
#include "core/parallel/nested_regions.h"
#include "core/parallel/team.h"

using namespace loomstone;

TEST_CASE("a loop visits every index once whatever the number of threads") {
  for (const int threads : {1, 2, 3, 7})
    for (const Index n : {0, 1, 511, 512, 513, 5000}) {
      std::vector<int> visits(n, 0);
      parallel_for(Team{threads}, n, [&](Index i) { ++visits[i]; }, 100);
      CHECK(std::count(visits.begin(), visits.end(), 1) == n);
    }
}

TEST_CASE("a sum has the same bits on any number of threads") {
  const auto term = [](Index i) { return std::sin(1.0 * i) / (1.0 + i); };
  const double one = parallel_sum(Team{1}, 100003, term);
  for (const int threads : {2, 3, 7}) {
    const double more = parallel_sum(Team{threads}, 100003, term);
    CHECK(std::memcmp(&one, &more, sizeof one) == 0);
  }
}

TEST_CASE("the time that threads spend in loops is reported for each thread") {
  const auto spin = [](double seconds) {
    const auto start = std::chrono::steady_clock::now();
    while (std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() <
           seconds) {
    }
  };
  for (const int threads : {1, 3}) {
    std::vector<double> busy(threads, 0.0);
    Team team{threads};
    team.busy = busy.data();
    parallel_tasks(team, 6, [&](Index) { spin(2e-3); });
    parallel_for(team, 6, [&](Index) { spin(1e-3); }, 1);
    double sum = 0.0;
    for (const double each : busy) {
      sum += each;
      CHECK(each >= (threads == 1 ? 18e-3 : 2e-3));  // 2 ms: a third of the second loop's work
    }
    CHECK(sum >= 18e-3);
  }
}

TEST_CASE("an exception propagates out of a loop") {
  for (const int threads : {1, 3})
    CHECK_THROWS_AS(parallel_for(
                        Team{threads}, 1000,
                        [](Index i) {
                          if (i == 777) throw InvalidInput("index 777");
                        },
                        10),
                    InvalidInput);
}

TEST_CASE("the default number of threads is that of OMP_NUM_THREADS, or the processors") {
  const char* found = std::getenv("OMP_NUM_THREADS");
  const std::string before = found ? found : "";
  unsetenv("OMP_NUM_THREADS");
  CHECK(available_processors() >= 1);
  CHECK(default_thread_count() == available_processors());
  const int other = available_processors() + 1;
  for (const std::string text : {"{}", " {} ", "{},1"}) {
    const std::string given = std::string(text).replace(text.find("{}"), 2, std::to_string(other));
    setenv("OMP_NUM_THREADS", given.c_str(), 1);
    CHECK(default_thread_count() == other);
  }
  for (const char* text : {"", "0", "-2", "many", "2x", "1000000"}) {
    setenv("OMP_NUM_THREADS", text, 1);
    CHECK(threads_in_environment() == 0);
    CHECK(default_thread_count() == available_processors());
  }
  if (found)
    setenv("OMP_NUM_THREADS", before.c_str(), 1);
  else
    unsetenv("OMP_NUM_THREADS");
}

TEST_CASE("a child forked after a parallel loop refuses to run one and still runs serial ones") {
  const auto code_of = [](auto&& body) {
    const pid_t child = fork();
    if (child == 0) _exit(body());
    int status = 0;
    waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  };
  const auto loop = [] {
    try {
      parallel_for(Team{2}, 1000, [](Index) {}, 10);
      return 0;
    } catch (const Unsupported& error) {
      return std::strstr(error.what(), "spawn") != nullptr ? 1 : 2;
    }
  };
  loop();
  CHECK(code_of(loop) == 1);
  CHECK(code_of([] {
          parallel_for(Team{1}, 1000, [](Index) {}, 10);  // a child process can run serial loops
          return 5;
        }) == 5);
}
