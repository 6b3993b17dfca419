// Tests of runs whose writer is killed, or finds the disk full, while it writes a frame, and of
// readers that are open meanwhile. For kills, the test program records the changes that the writer
// makes to its files, repeats them page by page on copies of the files, and reads the copies.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <fcntl.h>
#include <unistd.h>

#include "core/base/error.h"
#include "core/cache/frame_file.h"
#include "example_run.h"

using namespace loomstone;
using namespace loomstone::testing;

namespace {

struct Change {
  std::string file;  // name without the directory
  off_t at;          // position of the first byte written, or new length of the file [bytes]
  bool sets_length;
  std::vector<unsigned char> bytes;
};

std::vector<Change>* recorded_changes = nullptr;  // null: changes are not recorded
int writes_until_full = -1;  // writes that succeed before one fails; negative: none fails

void record(int descriptor, Change change) {
  if (!recorded_changes) return;
  const std::string link = "/proc/self/fd/" + std::to_string(descriptor);
  change.file = std::filesystem::read_symlink(link).filename();
  recorded_changes->push_back(std::move(change));
}

}  // namespace

// These functions replace those of the C library in this program, to record changes and to let a
// write fail.
extern "C" ssize_t pwrite(int descriptor, const void* buffer, std::size_t count, off_t at) {
  const auto* bytes = static_cast<const unsigned char*>(buffer);
  if (writes_until_full >= 0 && writes_until_full-- == 0) {
    errno = ENOSPC;
    return -1;
  }
  record(descriptor, {"", at, false, {bytes, bytes + count}});
  return pwrite64(descriptor, buffer, count, at);
}

extern "C" int ftruncate(int descriptor, off_t length) noexcept {
  record(descriptor, {"", length, true, {}});
  return ftruncate64(descriptor, length);
}

namespace {

// Size of a page of memory [bytes]. A kill can interrupt a write only between two pages.
constexpr off_t page = 4096;

// Repeats a change in the copy of a run in `directory`, page by page. Calls `visit` after each page
// and after a change of length.
template <class Visit>
void repeat(const Change& change, const std::string& directory, const Visit& visit) {
  const int file = ::open((directory + "/" + change.file).c_str(), O_RDWR | O_CLOEXEC);
  if (change.sets_length) REQUIRE(ftruncate64(file, change.at) == 0);
  const off_t end = change.at + static_cast<off_t>(change.bytes.size());
  for (off_t from = change.at; from < end;) {
    const off_t to = std::min((from / page + 1) * page, end);
    const auto count = static_cast<std::size_t>(to - from);
    REQUIRE(pwrite64(file, change.bytes.data() + (from - change.at), count, from) ==
            static_cast<ssize_t>(count));
    if (to < end) visit();
    from = to;
  }
  ::close(file);
  visit();
}

void copy_run(const TemporaryDirectory& from, const TemporaryDirectory& to) {
  for (const char* name : {"run.vtkhdf", "bodies.vtkhdf"})
    std::filesystem::copy_file(from / name, to / name,
                               std::filesystem::copy_options::overwrite_existing);
}

struct Pieces {
  FrameTopology topology;
  std::string directory;
  int n_frames = 0;  // frames that the last check found; at first, frames already written
  int n_checks = 0, n_wrong = 0;
  std::string first_fault = {};

  // Checks that no frame is lost, and compares the first frame and the last three with the example.
  void check() {
    ++n_checks;
    std::string fault;
    try {
      const FrameReader reader(directory);
      if (reader.n_frames() < n_frames) fault = "a frame is lost";
      n_frames = reader.n_frames();
      for (const int index : {0, n_frames - 3, n_frames - 2, n_frames - 1})
        if (!same(reader.frame(index), example_frame(topology, index)))
          fault = "frame " + std::to_string(index) + " is wrong";
    } catch (const CacheError& error) {
      fault = error.what();
    }
    n_wrong += !fault.empty();
    if (first_fault.empty()) first_fault = fault;
  }
};

}  // namespace

// All cases but the first add frames across a boundary in the files. With compression, a page of a
// chunk index (a B-tree node of HDF5) describes about 100 frames, and a node is split after 512
// frames. Without compression, a block contains 16 frames, and tables have 1024 rows per block.
TEST_CASE("a run is complete after every page that its writer writes") {
  struct Case {
    int compression, from, to;
  };
  const auto [compression, from, to] = GENERATE(Case{0, 4, 6}, Case{0, 15, 18}, Case{0, 1023, 1025},
                                                Case{1, 98, 104}, Case{1, 510, 514});
  const TemporaryDirectory written, copied;
  Pieces pieces{example_topology(3, true), copied.path(), from};
  FrameWriter writer(written.path(), pieces.topology, "", compression);
  for (int index = 0; index < from; ++index) write_example(writer, pieces.topology, index);
  copy_run(written, copied);
  std::vector<Change> changes;
  recorded_changes = &changes;
  for (int index = from; index < to; ++index) write_example(writer, pieces.topology, index);
  recorded_changes = nullptr;
  pieces.check();
  for (const Change& change : changes) repeat(change, pieces.directory, [&] { pieces.check(); });
  INFO(pieces.n_checks << " checks, first fault: " << pieces.first_fault);
  CHECK(pieces.n_wrong == 0);
  CHECK(pieces.n_frames == to);
  CHECK(pieces.n_checks > 40 * (to - from));
}

// With compression, a node of the chunk index is split while the frames are added.
TEST_CASE("a reader that stays open returns the frames that it has found, while a run grows") {
  const int compression = GENERATE(0, 1), from = 960, to = 1060;
  CAPTURE(compression);
  const TemporaryDirectory written, copied;
  const FrameTopology topology = example_topology(2, true);
  FrameWriter writer(written.path(), topology, "", compression);
  for (int index = 0; index < from; ++index) write_example(writer, topology, index);
  copy_run(written, copied);
  const FrameReader busy(copied.path()), idle(copied.path());
  std::vector<Change> changes;
  recorded_changes = &changes;
  for (int index = from; index < to; ++index) write_example(writer, topology, index);
  recorded_changes = nullptr;
  int n_wrong = 0, n_changes = 0;
  for (const Change& change : changes) {
    repeat(change, copied.path(), [] {});
    if (++n_changes % 16 != 0) continue;
    const int index = from - 1 - n_changes / 16 % 40;
    n_wrong += !same(busy.frame(index), example_frame(topology, index));
  }
  // The idle reader reads its frames only here, after all changes.
  for (int index = 0; index < from; index += index < from - 60 ? 20 : 1)
    n_wrong += !same(idle.frame(index), example_frame(topology, index));
  CHECK(n_wrong == 0);
  CHECK(busy.n_frames() == from);
  CHECK(FrameReader(copied.path()).n_frames() == to);  // a new reader finds the new frames
}

TEST_CASE("a reader in the process of a writer that fails returns the frames that it has found") {
  const int compression = GENERATE(0, 1), n_frames = 20;
  CAPTURE(compression);
  const FrameTopology topology = example_topology(2, true);
  bool failed = true;
  for (int position = 0; failed; position += 3) {
    CAPTURE(position);
    const TemporaryDirectory directory;
    auto writer = std::make_unique<FrameWriter>(directory.path(), topology, "", compression);
    for (int index = 0; index < n_frames; ++index) write_example(*writer, topology, index);
    const FrameReader reader(directory.path());
    writes_until_full = position;
    try {
      write_example(*writer, topology, n_frames);
    } catch (const CacheError&) {
    }
    failed = writes_until_full < 0;
    writer.reset();
    writes_until_full = -1;
    int n_wrong = 0;
    for (int index = 0; index < n_frames; ++index)
      n_wrong += !same(reader.frame(index), example_frame(topology, index));
    CHECK(n_wrong == 0);
  }
}

// In a file without compression, the frame after 5 frames fits into the blocks that exist, and the
// frame after 16 frames needs new ones.
TEST_CASE("after any write that failed, a run is complete, and the frame can be written again") {
  const int compression = GENERATE(0, 1), n_before = GENERATE(5, 16);
  CAPTURE(compression, n_before);
  int n_failed = 0;
  for (int position = 0; position >= 0; ++position) {
    const TemporaryDirectory written, copied;
    Pieces pieces{example_topology(3, true), copied.path(), n_before};
    FrameWriter writer(written.path(), pieces.topology, "", compression);
    for (int index = 0; index < n_before; ++index) write_example(writer, pieces.topology, index);
    const auto check = [&] {
      copy_run(written, copied);
      pieces.check();
    };
    writes_until_full = position;
    bool failed = false;
    try {
      write_example(writer, pieces.topology, n_before);
    } catch (const CacheError& error) {
      failed = std::string(error.what()).find("No space left on device") != std::string::npos;
    }
    if (writes_until_full >= 0) break;  // no write failed: the frame takes `position` writes
    CAPTURE(position);
    CHECK(failed);
    check();
    for (int index = n_before; index < n_before + 2; ++index) {
      write_example(writer, pieces.topology, index);
      check();
    }
    INFO("first fault: " << pieces.first_fault);
    CHECK(pieces.n_wrong == 0);
    CHECK(pieces.n_frames == n_before + 2);
    ++n_failed;
  }
  writes_until_full = -1;
  CHECK(n_failed > 20);
}
