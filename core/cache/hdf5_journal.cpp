#include "core/cache/hdf5_journal.h"

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <iterator>

#include <sys/stat.h>
#include <unistd.h>

#include "core/base/word_hash.h"

namespace loomstone {

namespace {

constexpr std::uint64_t trailer_mark = 0x6c6e726a6d6f6f6cULL;  // "loomjrnl"

void append(std::vector<unsigned char>& records, std::uint64_t number) {
  const auto* bytes = reinterpret_cast<const unsigned char*>(&number);
  records.insert(records.end(), bytes, bytes + sizeof number);
}

std::span<const unsigned char> head_of(const JournalTrailer& trailer) {
  return {reinterpret_cast<const unsigned char*>(&trailer), offsetof(JournalTrailer, trailer)};
}

// Head of a record: the address of its bytes in the file, and their number. The bytes follow the
// head.
struct RecordHead {
  std::uint64_t address, count;
};

// Returns whether the records between `start` and `end` in the file are complete, do not overlap,
// have ascending addresses, and change only bytes before `start`. Reads only their heads.
bool records_fit(int file, std::uint64_t start, std::uint64_t end) {
  std::uint64_t at = start, least = 0;
  while (at < end) {
    RecordHead head = {};
    if (end - at < sizeof head ||
        !read_fully(file, at, {reinterpret_cast<unsigned char*>(&head), sizeof head}))
      return false;
    at += sizeof head;
    if (head.address < least || head.address > start || head.count == 0 ||
        head.count > start - head.address || head.count > end - at)
      return false;
    least = head.address + head.count;
    at += head.count;
  }
  return true;
}

// Returns the bytes that `records` contains. records_fit() must be true for these records.
PendingBytes parsed(std::span<const unsigned char> records) {
  PendingBytes result;
  while (!records.empty()) {
    RecordHead head = {};
    std::memcpy(&head, records.data(), sizeof head);
    records = records.subspan(sizeof head);
    result.put(head.address, records.first(head.count));
    records = records.subspan(head.count);
  }
  return result;
}

}  // namespace

// Returns the first range that ends beyond `address`, or ranges_.end() if there is none.
PendingBytes::Ranges::const_iterator PendingBytes::first_overlap(std::uint64_t address) const {
  auto range = ranges_.upper_bound(address);
  if (range != ranges_.begin()) {
    const auto before = std::prev(range);
    if (before->first + before->second.size() > address) return before;
  }
  return range;
}

std::uint64_t PendingBytes::end() const {
  return ranges_.empty() ? 0 : ranges_.rbegin()->first + ranges_.rbegin()->second.size();
}

bool PendingBytes::overlap(std::uint64_t address, std::uint64_t count) const {
  const auto range = first_overlap(address);
  return count > 0 && range != ranges_.end() && range->first < address + count;
}

void PendingBytes::put(std::uint64_t address, std::span<const unsigned char> bytes) {
  if (bytes.empty()) return;
  const std::uint64_t end = address + bytes.size();
  const auto first = first_overlap(address);
  auto last = first;
  std::uint64_t from = address, to = end;
  for (; last != ranges_.end() && last->first < end; ++last) {
    from = std::min(from, last->first);
    to = std::max(to, last->first + last->second.size());
  }
  std::vector<unsigned char> merged(to - from);
  for (auto range = first; range != last; ++range)
    std::copy(range->second.begin(), range->second.end(),
              merged.begin() + static_cast<std::ptrdiff_t>(range->first - from));
  std::copy(bytes.begin(), bytes.end(),
            merged.begin() + static_cast<std::ptrdiff_t>(address - from));
  ranges_.erase(first, last);
  ranges_.emplace(from, std::move(merged));
}

std::pair<PendingBytes, PendingBytes> PendingBytes::split_at(std::uint64_t address) const {
  std::pair<PendingBytes, PendingBytes> result;
  for (const auto& [start, bytes] : ranges_) {
    const std::span<const unsigned char> range(bytes);
    const std::size_t n_before =
        std::min<std::size_t>(range.size(), address > start ? address - start : 0);
    result.first.put(start, range.first(n_before));
    result.second.put(start + n_before, range.subspan(n_before));
  }
  return result;
}

void PendingBytes::apply_to(std::uint64_t address, std::span<unsigned char> bytes) const {
  const std::uint64_t end = address + bytes.size();
  for (auto range = first_overlap(address); range != ranges_.end() && range->first < end; ++range) {
    const std::uint64_t from = std::max(address, range->first),
                        to = std::min(end, range->first + range->second.size());
    std::memcpy(bytes.data() + (from - address), range->second.data() + (from - range->first),
                to - from);
  }
}

std::vector<unsigned char> journal_records(const PendingBytes& bytes) {
  std::vector<unsigned char> records;
  for (const auto& [address, range] : bytes.ranges()) {
    append(records, address);
    append(records, range.size());
    records.insert(records.end(), range.begin(), range.end());
  }
  return records;
}

JournalTrailer journal_trailer(std::uint64_t start, std::span<const unsigned char> records) {
  JournalTrailer trailer{trailer_mark, start, checksum_of(records), 0};
  trailer.trailer = checksum_of(head_of(trailer));
  return trailer;
}

std::optional<Journal> read_journal(int file) {
  struct stat status = {};
  JournalTrailer trailer = {};
  if (fstat(file, &status) != 0) return std::nullopt;
  const auto length = static_cast<std::uint64_t>(status.st_size);
  if (length < sizeof trailer) return std::nullopt;
  const std::uint64_t end = length - sizeof trailer;
  if (!read_fully(file, end, {reinterpret_cast<unsigned char*>(&trailer), sizeof trailer}) ||
      trailer.mark != trailer_mark || trailer.trailer != checksum_of(head_of(trailer)) ||
      trailer.start > end || !records_fit(file, trailer.start, end))
    return std::nullopt;
  std::vector<unsigned char> records(end - trailer.start);
  if (!read_fully(file, trailer.start, records) || checksum_of(records) != trailer.records)
    return std::nullopt;
  return Journal{trailer.start, parsed(records)};
}

bool read_fully(int file, std::uint64_t address, std::span<unsigned char> bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::pread(file, bytes.data(), bytes.size(), static_cast<off_t>(address));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return false;
    if (n == 0) {
      std::fill(bytes.begin(), bytes.end(), static_cast<unsigned char>(0));
      return true;
    }
    bytes = bytes.subspan(static_cast<std::size_t>(n));
    address += static_cast<std::uint64_t>(n);
  }
  return true;
}

bool write_fully(int file, std::uint64_t address, std::span<const unsigned char> bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::pwrite(file, bytes.data(), bytes.size(), static_cast<off_t>(address));
    if (n < 0 && errno == EINTR) continue;
    if (n == 0) errno = EIO;
    if (n <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(n));
    address += static_cast<std::uint64_t>(n);
  }
  return true;
}

}  // namespace loomstone
