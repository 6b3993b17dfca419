// Tests of runs that are killed at random moments: whether their files can be read and continued.
#include <catch2/catch.hpp>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <random>
#include <string>

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/base/error.h"
#include "core/cache/checkpoint_file.h"
#include "example_run.h"

using namespace loomstone;
using namespace loomstone::testing;

namespace {

// Runs `work` in a child process and kills it (SIGKILL) after the given number of microseconds; 0
// means never. Returns whether the child was killed. If it was not, checks that it succeeded.
template <class Work>
bool kill_after(unsigned microseconds, const Work& work) {
  const pid_t child = fork();
  if (child == 0) {
    try {
      work();
    } catch (...) {
      _exit(1);
    }
    _exit(0);
  }
  if (microseconds > 0) {
    usleep(microseconds);
    kill(child, SIGKILL);
  }
  int status = 0;
  waitpid(child, &status, 0);
  if (!WIFSIGNALED(status)) CHECK(WEXITSTATUS(status) == 0);
  return WIFSIGNALED(status);
}

// Compares the topology and every frame of a run with the example. Returns the number of frames.
int check_run(const std::string& directory, const FrameTopology& topology) {
  const FrameReader reader(directory);
  CHECK(same(reader.topology(), topology));
  int n_wrong = 0;
  for (int index = 0; index < reader.n_frames(); ++index)
    n_wrong += !same(reader.frame(index), example_frame(topology, index));
  CHECK(n_wrong == 0);
  return reader.n_frames();
}

int number_of_kills(int usual) {
  const char* text = std::getenv("LOOMSTONE_KILLS");
  return text ? std::atoi(text) : usual;
}

}  // namespace

TEST_CASE("a run killed at any moment can be read, and every frame is right") {
  const int compression = GENERATE(0, 1);
  const FrameTopology topology = example_topology(6, true);
  const auto write = [&](const std::string& directory, int n_frames) {
    FrameWriter writer(directory, topology, "", compression);
    for (int index = 0; index < n_frames; ++index) write_example(writer, topology, index);
  };
  // The window of kill times is at least three times as long as the time that ten frames take. Thus
  // some kills come while frames are written, even if the program is slow or runs in a debugger.
  const auto start = std::chrono::steady_clock::now();
  {
    const TemporaryDirectory directory;
    kill_after(0, [&] { write(directory.path(), 10); });
  }
  const auto ten_frames = std::chrono::duration_cast<std::chrono::microseconds>(
      std::chrono::steady_clock::now() - start);
  const unsigned window = std::max<unsigned>(60000, 3 * static_cast<unsigned>(ten_frames.count()));
  std::mt19937 random(1);
  int n_killed = 0, most = 0;
  for (int trial = 0; trial < number_of_kills(20); ++trial) {
    const TemporaryDirectory directory;
    {
      const FrameWriter empty(directory.path(), topology, "");
    }
    const bool killed = kill_after(1 + random() % window, [&] { write(directory.path(), 100000); });
    n_killed += killed;
    try {
      most = std::max(most, check_run(directory.path(), topology));
    } catch (const CacheError& error) {
      // The run file is absent between the removal of the old one and the renaming of the new one.
      const bool absent = std::string(error.what()).find("No such file") != std::string::npos;
      if (!absent) FAIL_CHECK(error.what());
    }
  }
  CHECK(n_killed == number_of_kills(20));
  CHECK(most > 0);  // at least one kill came after a frame was written
}

TEST_CASE("a run killed and continued repeatedly ends with the content of an uninterrupted one") {
  const FrameTopology topology = example_topology(6, true);
  const int n_frames = 300, most_kills = 10;
  std::mt19937 random(2);
  const TemporaryDirectory directory;
  {
    const FrameWriter kept(directory.path(), topology, "kept");
  }
  // A checkpoint follows every fifth frame.
  const std::string checkpoint_path = directory / "state.checkpoint";
  const auto checkpoint = [](int next) {
    Checkpoint result;
    result.integers["next frame"] = {next};
    return result;
  };
  write_checkpoint(checkpoint_path, checkpoint(0));
  int n_killed = 0;
  for (bool done = false; !done;) {
    const unsigned moment = 20000 + random() % 100000;
    done = !kill_after(n_killed < most_kills ? moment : 0, [&] {
      const int next =
          static_cast<int>(read_checkpoint(checkpoint_path).integers.at("next frame").at(0));
      const double until = next == 0 ? -1.0 : example_frame(topology, next - 1).time;
      FrameWriter writer = FrameWriter::reopen(directory.path(), until);
      // A checkpoint never refers to a frame that is missing from the file.
      if (writer.n_frames() != next) _exit(2);
      for (int index = next; index < n_frames; ++index) {
        write_example(writer, topology, index);
        if (index % 5 == 4) write_checkpoint(checkpoint_path, checkpoint(index + 1));
      }
    });
    n_killed += !done;
  }
  CHECK(n_killed > 1);
  CHECK(check_run(directory.path(), topology) == n_frames);
  CHECK(FrameReader(directory.path()).metadata() == "kept");
}

TEST_CASE("a checkpoint being replaced when its writer is killed is the old one or the new one") {
  const TemporaryDirectory directory;
  const std::string path = directory / "state.checkpoint";
  std::mt19937 random(3);
  const auto checkpoint = [](double number) {
    Checkpoint result;
    result.arrays["number"] = {{1000}, std::vector<double>(1000, number)};
    return result;
  };
  write_checkpoint(path, checkpoint(-1));
  for (int trial = 0; trial < number_of_kills(20); ++trial) {
    kill_after(1 + random() % 10000, [&] {
      for (int number = 0; number < 100000; ++number) write_checkpoint(path, checkpoint(number));
    });
    const auto values = read_checkpoint(path).arrays.at("number").values;
    CHECK(values == std::vector<double>(1000, values.at(0)));
  }
}
