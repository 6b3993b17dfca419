// A journal of bytes that replace parts of a file. A writer adds the journal to the end of the file
// before it changes these parts, and removes it afterwards. If the writer is killed in between, a
// reader takes the bytes from the journal, so it sees all changes or none.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace loomstone {

// Bytes that take the place of bytes of a file, as ranges that do not overlap.
class PendingBytes {
 public:
  bool empty() const { return ranges_.empty(); }
  void clear() { ranges_.clear(); }
  std::uint64_t end() const;  // address at which the last range ends, or 0 without ranges
  bool overlap(std::uint64_t address, std::uint64_t count) const;
  // Adds `bytes`, which belong at `address` in the file. They replace pending bytes at the same
  // addresses.
  void put(std::uint64_t address, std::span<const unsigned char> bytes);
  // Returns the pending bytes before `address` and those from `address` on.
  std::pair<PendingBytes, PendingBytes> split_at(std::uint64_t address) const;
  // Overwrites `bytes`, read from the file at `address`, with the pending bytes of this range.
  void apply_to(std::uint64_t address, std::span<unsigned char> bytes) const;
  const std::map<std::uint64_t, std::vector<unsigned char>>& ranges() const { return ranges_; }

 private:
  using Ranges = std::map<std::uint64_t, std::vector<unsigned char>>;
  Ranges::const_iterator first_overlap(std::uint64_t address) const;
  Ranges ranges_;  // maps the address of each range to its bytes
};

// The journal consists of records (address, count, bytes), in ascending order of their addresses,
// and of a trailer, which a writer must write last. A file has a journal if it ends with a trailer
// that fits the records.
struct JournalTrailer {
  // `mark` identifies a trailer. `start` is the length of the file without the journal [bytes].
  std::uint64_t mark, start;
  std::uint64_t records, trailer;  // checksums of the records, and of all numbers before `trailer`
};

struct Journal {
  std::uint64_t start = 0;  // length of the file without the journal [bytes]
  PendingBytes bytes;
};

std::vector<unsigned char> journal_records(const PendingBytes& bytes);
JournalTrailer journal_trailer(std::uint64_t start, std::span<const unsigned char> records);

// Returns the journal at the end of an open file, or nothing if the file has none.
std::optional<Journal> read_journal(int file);

// Like pread() and pwrite(), but continue until all bytes are transferred. read_fully() sets bytes
// beyond the end of the file to 0. Both return false, with errno set, if the system refuses.
bool read_fully(int file, std::uint64_t address, std::span<unsigned char> bytes);
bool write_fully(int file, std::uint64_t address, std::span<const unsigned char> bytes);

}  // namespace loomstone
