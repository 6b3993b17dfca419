// Tests of files that are missing, foreign, of another version, truncated or damaged, and of files
// that cannot be written, for example because the disk is full.
#include <catch2/catch.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>

#include <signal.h>
#include <sys/resource.h>

#include "core/base/error.h"
#include "core/base/word_hash.h"
#include "core/cache/checkpoint_file.h"
#include "core/cache/hdf5_file.h"
#include "example_run.h"

using namespace loomstone;
using namespace loomstone::testing;
using Catch::Contains;

namespace {

std::string message_of(const std::string& path) {
  try {
    FrameReader reader(path);
    for (int index = 0; index < reader.n_frames(); ++index) reader.frame(index);
  } catch (const CacheError& error) {
    return error.what();
  }
  return "";
}

std::string checkpoint_message_of(const std::string& path) {
  try {
    read_checkpoint(path);
  } catch (const CacheError& error) {
    return error.what();
  }
  return "";
}

void write_run(const std::string& directory, int n_frames, bool with_bodies = true) {
  const FrameTopology topology = example_topology(4, with_bodies);
  FrameWriter writer(directory, topology, "");
  for (int index = 0; index < n_frames; ++index) write_example(writer, topology, index);
}

void flip_bit(const std::string& path, std::uintmax_t at) {
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekg(static_cast<std::streamoff>(at));
  const char byte = static_cast<char>(file.get() ^ 4);
  file.seekp(static_cast<std::streamoff>(at));
  file.put(byte);
}

// Writes a checkpoint file that ends like those of write_checkpoint(): mark, length and checksum.
void write_with_checksum(const std::string& path, std::vector<unsigned char> bytes) {
  WordHash hash;
  for (std::size_t at = 0; at < bytes.size(); at += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data() + at, std::min<std::size_t>(8, bytes.size() - at));
    hash.add(word);
  }
  const std::array<std::uint64_t, 2> numbers = {bytes.size(), hash.sum};
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  file.write("LOOMCHK\n", 8);
  file.write(reinterpret_cast<const char*>(numbers.data()), sizeof numbers);
}

// While an instance exists, no file of this process can grow beyond `bytes`, as on a full disk.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) {
    signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FullDisk() { setrlimit(RLIMIT_FSIZE, &before_); }

 private:
  rlimit before_ = {};
};

}  // namespace

TEST_CASE("a missing, empty or foreign file is named with what is wrong") {
  const TemporaryDirectory directory;
  CHECK_THAT(message_of(directory.path()), Contains("run.vtkhdf") && Contains("No such file"));
  std::ofstream(directory / "run.vtkhdf").flush();
  CHECK_THAT(message_of(directory.path()), Contains("not an HDF5 file"));
  std::ofstream(directory / "run.vtkhdf") << "# vtk DataFile Version 3.0";
  CHECK_THAT(message_of(directory / "run.vtkhdf"), Contains("not an HDF5 file"));
  Hdf5File::create(directory / "run.vtkhdf").close();
  CHECK_THAT(message_of(directory / "run.vtkhdf"),
             Contains("is an HDF5 file but not a loomstone cache"));
}

TEST_CASE("a file of a newer format is refused with both numbers") {
  const TemporaryDirectory directory;
  Hdf5File file = Hdf5File::create(directory / "run.vtkhdf");
  file.create_group("/loomstone");
  file.write_attribute("/loomstone", "format", std::array<std::int64_t, 1>{4});
  file.write_text_attribute("/loomstone", "kind", "run");
  file.close();
  CHECK_THAT(message_of(directory.path()),
             Contains("written by a newer version (file format 4, this build reads up to 3)"));
}

TEST_CASE("a file of an older format is refused with both numbers") {
  const TemporaryDirectory directory;
  Hdf5File file = Hdf5File::create(directory / "run.vtkhdf");
  file.create_group("/loomstone");
  file.write_attribute("/loomstone", "format", std::array<std::int64_t, 1>{2});
  file.write_text_attribute("/loomstone", "kind", "run");
  file.close();
  CHECK_THAT(message_of(directory.path()),
             Contains("written by an older version (file format 2, this build reads 3)"));
}

TEST_CASE("a checkpoint of a newer format is refused with both numbers") {
  const TemporaryDirectory directory;
  const std::string path = directory / "state.checkpoint";
  Hdf5File file = Hdf5File::create_in_memory(path);
  file.write_attribute("/", "format", std::array<std::int64_t, 1>{3});
  file.write_text_attribute("/", "kind", "checkpoint");
  write_with_checksum(path, file.image());
  CHECK_THAT(
      checkpoint_message_of(path),
      Contains("written by a newer version (checkpoint format 3, this build reads up to 2)"));
}

TEST_CASE("texts that are not UTF-8 are refused") {
  const TemporaryDirectory directory;
  const std::string path = directory / "texts";
  const char* bad[] = {"\x80",         "a\xC3",        "\xC0\xAF",
                       "\xE0\x80\x80", "\xED\xA0\x80", "\xF5\x80\x80\x80"};
  const std::vector<std::string> good = {"", "\xC3\xA9", "\xE2\x82\xAC", "\xF0\x9F\x98\x80 x"};
  {
    Hdf5File file = Hdf5File::create(path);
    for (int i = 0; i < 6; ++i) file.write_text("/bad" + std::to_string(i), bad[i]);
    file.write_texts("/good", good);
    file.flush();
  }
  const Hdf5File file = Hdf5File::open(path);
  CHECK(file.read_texts("/good") == good);
  for (int i = 0; i < 6; ++i)
    CHECK_THROWS_WITH(file.read_text("/bad" + std::to_string(i)), Contains("is not UTF-8"));
}

TEST_CASE("columns that an older file lacks keep their defaults") {
  struct Row {
    std::int64_t step = -1;
    double energy = 0.5;  // a member that the older file does not contain
    double time = -1.0;
  };
  const Column step{"step", Number::Int64, offsetof(Row, step)};
  const Column time{"time", Number::Float64, offsetof(Row, time)};
  const Column energy{"energy", Number::Float64, offsetof(Row, energy)};
  const TemporaryDirectory directory;
  {
    Hdf5File file = Hdf5File::create(directory / "older");
    Hdf5Rows rows = file.create_rows("/rows", {.columns = {step, time}, .bytes = sizeof(Row)}, {4});
    const std::array<Row, 2> written = {Row{1, 7.0, 0.1}, Row{2, 7.0, 0.2}};
    rows.resize(2);
    rows.write(0, 2, written.data());
    file.flush();
  }
  std::array<Row, 2> read;
  Hdf5File::open(directory / "older")
      .open_rows("/rows", {.columns = {step, energy, time}, .bytes = sizeof(Row)})
      .read(0, 2, read.data());
  for (const int row : {0, 1}) {
    CHECK(read[row].step == row + 1);
    CHECK(read[row].time == 0.1 * (row + 1));
    CHECK(read[row].energy == 0.5);
  }
}

TEST_CASE(
    "the bodies file cannot replace the run file, nor can the bodies file of another run be used") {
  const TemporaryDirectory directory, other;
  write_run(directory.path(), 3);
  CHECK_THAT(message_of(directory / "bodies.vtkhdf"), Contains("kind 'run', got 'bodies'"));
  const FrameTopology topology = example_topology(4, true);
  {
    FrameWriter writer(other.path(), topology, "");
    writer.write(example_frame(topology, 7));
  }
  std::filesystem::copy_file(other / "bodies.vtkhdf", directory / "bodies.vtkhdf",
                             std::filesystem::copy_options::overwrite_existing);
  CHECK_THAT(message_of(directory.path()), Contains("belongs to another run"));
  std::filesystem::remove(directory / "bodies.vtkhdf");
  CHECK_THAT(message_of(directory.path()), Contains("bodies.vtkhdf") && Contains("No such file"));
}

TEST_CASE("a run truncated anywhere is an error, never wrong numbers") {
  const TemporaryDirectory directory;
  write_run(directory.path(), 3, false);
  const std::string path = directory / "run.vtkhdf";
  const auto length = std::filesystem::file_size(path);
  for (int part = 19; part > 0; --part) {
    std::filesystem::resize_file(path, length * static_cast<std::uintmax_t>(part) / 20);
    CHECK_THAT(message_of(path), Contains(path) && Contains("truncated"));
  }
  std::filesystem::resize_file(path, 4);
  CHECK_THAT(message_of(path), Contains("not an HDF5 file"));
}

TEST_CASE("a checkpoint truncated or with any bit flipped is refused") {
  const TemporaryDirectory directory;
  const std::string path = directory / "state.checkpoint";
  Checkpoint checkpoint;
  checkpoint.arrays["positions"] = {{100, 3}, std::vector<double>(300, 0.1)};
  write_checkpoint(path, checkpoint);
  const auto length = std::filesystem::file_size(path);
  for (std::uintmax_t at = 0; at < length; at += 7) {
    flip_bit(path, at);
    if (checkpoint_message_of(path).empty()) FAIL_CHECK("bit " << at << " may flip unnoticed");
    flip_bit(path, at);
  }
  CHECK(checkpoint_message_of(path).empty());
  flip_bit(path, 3000);
  CHECK_THAT(checkpoint_message_of(path), Contains("checksum does not match"));
  flip_bit(path, 3000);
  for (std::uintmax_t shorter :
       {length - 1, length - 24, length / 2, std::uintmax_t{3}, std::uintmax_t{0}}) {
    std::filesystem::resize_file(path, shorter);
    CHECK_THAT(checkpoint_message_of(path), Contains("truncated"));
  }
  std::filesystem::remove(path);
  CHECK_THAT(checkpoint_message_of(path), Contains("No such file"));
}

TEST_CASE("values that cannot be written are refused by name") {
  const TemporaryDirectory directory;
  const FrameTopology topology = example_topology(4, false);
  CHECK_THROWS_WITH(FrameWriter(directory / "absent", topology, ""),
                    Contains("absent") && Contains("No such file"));
  CHECK_THROWS_WITH(write_checkpoint(directory / "absent/a", {}),
                    Contains("absent") && Contains("No such file"));
  FrameWriter writer(directory.path(), topology, "");
  Frame frame = example_frame(topology, 0);
  frame.strain.resize(2, 3);
  CHECK_THROWS_WITH(writer.write(frame),
                    Contains("frame.strain must have 36 rows of 3") && Contains("got 2"));
  FrameTopology wrong = topology;
  wrong.corner_uv.resize(5, 2);
  CHECK_THROWS_WITH(FrameWriter(directory.path(), wrong, ""),
                    Contains("topology.corner_uv must have 108 entries, got 5"));
  Checkpoint checkpoint;
  checkpoint.arrays["positions"] = {{2, 3}, {1.0}};
  CHECK_THROWS_WITH(write_checkpoint(directory / "a", checkpoint),
                    Contains("'positions'") && Contains("got 1"));
  checkpoint.arrays = {{"", {{}, {1.0}}}};
  CHECK_THROWS_WITH(write_checkpoint(directory / "a", checkpoint),
                    Contains("names in a checkpoint must not be empty"));
  CHECK_THROWS_WITH(FrameReader(directory.path()).frame(0),
                    Contains("frame index must be in [0, 0), got 0"));
}

TEST_CASE("a writer that fails on a full disk leaves the frames it has written") {
  for (const rlim_t limit : {900000, 1900000, 2000000, 2200000, 2600000}) {
    const TemporaryDirectory directory;
    const FrameTopology topology = example_topology(12, true);
    int n_written = 0;
    {
      const FullDisk full(limit);
      FrameWriter writer(directory.path(), topology, "");
      CHECK_THROWS_AS(
          [&] {
            for (; n_written < 1000; ++n_written) write_example(writer, topology, n_written);
          }(),
          CacheError);
    }
    INFO("files of " << limit << " bytes at most, " << n_written << " frames");
    CHECK((n_written > 0 || limit == 900000));  // the first frame may need more than 900000 bytes
    const FrameReader reader(directory.path());
    REQUIRE(reader.n_frames() == n_written);
    for (int index = 0; index < n_written; ++index)
      CHECK(same(reader.frame(index), example_frame(topology, index)));
  }
}

TEST_CASE("a full disk stops a run with an error, and the frames before it stay") {
  const TemporaryDirectory directory;
  const FrameTopology topology = example_topology(12, true);
  FrameWriter writer(directory.path(), topology, "");
  int n_written = 0;
  std::string message;
  {
    const FullDisk full(3000000);
    try {
      for (; n_written < 1000; ++n_written) write_example(writer, topology, n_written);
    } catch (const CacheError& error) {
      message = error.what();
    }
    Checkpoint large;
    large.arrays["a"] = {{1000000}, std::vector<double>(1000000)};
    CHECK_THROWS_WITH(write_checkpoint(directory / "a.checkpoint", large),
                      Contains("File too large"));
    CHECK(!std::filesystem::exists(directory / "a.checkpoint"));
  }
  CHECK_THAT(message, Contains("run.vtkhdf") && Contains("File too large"));
  CHECK(n_written > 0);
  CHECK(n_written < 1000);
  {
    const FrameReader reader(directory.path());
    CHECK(reader.n_frames() == n_written);
    for (int index = 0; index < n_written; ++index)
      CHECK(same(reader.frame(index), example_frame(topology, index)));
  }
  // Once there is space again, the failed frame is written and the run continues.
  for (int index = n_written; index < n_written + 20; ++index)
    writer.write(example_frame(topology, index));
  const FrameReader reader(directory.path());
  REQUIRE(reader.n_frames() == n_written + 20);
  for (int index = 0; index < reader.n_frames(); ++index)
    CHECK(same(reader.frame(index), example_frame(topology, index)));
}
