// Tests of the journal at the end of a file, and of the pending bytes that the journal contains.
#include <catch2/catch.hpp>

#include <algorithm>
#include <optional>
#include <random>
#include <vector>

#include <fcntl.h>
#include <unistd.h>

#include "core/cache/hdf5_journal.h"
#include "example_run.h"

using namespace loomstone;
using namespace loomstone::testing;

namespace {

using Bytes = std::vector<unsigned char>;

constexpr std::uint64_t start = 1000;  // length of the file without the journal

// A file of `start` zeros, followed by the records and, if `ends` is true, by a trailer that fits
// the records.
class JournalFile {
 public:
  JournalFile(const Bytes& records, bool ends = true)
      : descriptor_(::open((directory_ / "file").c_str(), O_RDWR | O_CREAT, 0600)) {
    REQUIRE(write_fully(descriptor_, 0, Bytes(start)));
    REQUIRE(write_fully(descriptor_, start, records));
    if (!ends) return;
    const JournalTrailer trailer = journal_trailer(start, records);
    REQUIRE(write_fully(descriptor_, start + records.size(),
                        {reinterpret_cast<const unsigned char*>(&trailer), sizeof trailer}));
  }
  ~JournalFile() { ::close(descriptor_); }
  std::optional<Journal> read() const { return read_journal(descriptor_); }
  // Inverts one bit of the byte at `place`.
  void flip(std::uint64_t place, int bit) {
    Bytes byte(1);
    REQUIRE(read_fully(descriptor_, place, byte));
    byte[0] ^= static_cast<unsigned char>(1 << bit);
    REQUIRE(write_fully(descriptor_, place, byte));
  }

 private:
  TemporaryDirectory directory_;
  int descriptor_;
};

struct Record {
  std::uint64_t address, count;
  // Number of bytes that follow address and count. It equals `count` if the record is valid.
  std::uint64_t n_bytes;
};

Bytes records_of(const std::vector<Record>& records) {
  Bytes bytes;
  for (const Record& record : records) {
    const auto* head = reinterpret_cast<const unsigned char*>(&record);
    bytes.insert(bytes.end(), head, head + 16);
    bytes.resize(bytes.size() + record.n_bytes, 'x');
  }
  return bytes;
}

}  // namespace

TEST_CASE("pending bytes are those that were put last, whatever ranges overlap") {
  std::mt19937 random(1);
  for (int trial = 0; trial < 200; ++trial) {
    PendingBytes pending;
    Bytes expected(300, 0);
    std::vector<bool> known(300, false);
    for (int k = 0; k < 20; ++k) {
      const std::size_t from = random() % 280, count = random() % 20;
      const Bytes bytes(count, static_cast<unsigned char>(random()));
      CHECK(pending.overlap(from, count) == std::any_of(known.begin() + from,
                                                        known.begin() + from + count,
                                                        [](bool there) { return there; }));
      pending.put(from, bytes);
      std::copy(bytes.begin(), bytes.end(), expected.begin() + from);
      std::fill(known.begin() + from, known.begin() + from + count, true);
    }
    Bytes whole(300, 0), halves(300, 0), part(50, 0);
    pending.apply_to(0, whole);
    CHECK(whole == expected);
    const std::size_t place = random() % 300;
    const auto [before, after] = pending.split_at(place);
    CHECK(before.end() <= place);
    CHECK_FALSE(after.overlap(0, place));
    before.apply_to(0, halves), after.apply_to(0, halves);
    CHECK(halves == expected);
    pending.apply_to(100, part);
    CHECK(part == Bytes(expected.begin() + 100, expected.begin() + 150));
    const std::optional<Journal> journal = JournalFile(journal_records(pending)).read();
    REQUIRE(journal);
    CHECK(journal->start == start);
    CHECK(journal->bytes.ranges() == pending.ranges());
  }
}

TEST_CASE("a journal with any wrong bit, or without its end, counts as none") {
  const Bytes records = records_of({{8, 5, 5}, {40, 100, 100}});
  CHECK(JournalFile(records).read());
  CHECK_FALSE(JournalFile(records, false).read());
  for (std::uint64_t byte = 0; byte < records.size() + sizeof(JournalTrailer); ++byte) {
    JournalFile file(records);
    file.flip(start + byte, static_cast<int>(byte % 8));
    CAPTURE(byte);
    CHECK_FALSE(file.read());
  }
}

TEST_CASE("records that no writer makes are refused before memory is allocated") {
  constexpr std::uint64_t huge = ~std::uint64_t{0};
  CHECK_FALSE(JournalFile(records_of({{8, 5, 5}, {10, 5, 5}})).read());          // overlap
  CHECK_FALSE(JournalFile(records_of({{40, 5, 5}, {10, 5, 5}})).read());         // order
  CHECK_FALSE(JournalFile(records_of({{998, 5, 5}})).read());                    // beyond `start`
  CHECK_FALSE(JournalFile(records_of({{8, 0, 0}})).read());                      // empty
  CHECK_FALSE(JournalFile(records_of({{8, 50, 5}})).read());                     // too short
  CHECK_FALSE(JournalFile(records_of({{8, huge, 5}})).read());                   // too long
  CHECK_FALSE(JournalFile(records_of({{huge - 7, 50, 50}})).read());             // end overflows
  CHECK_FALSE(JournalFile(records_of({{huge - 7, 50, 50}, {9, 5, 5}})).read());  // both
}
