// FNV-1a hash over words of eight bytes, with an additional shift that mixes high bits into low
// ones. The hash is an invertible function of each word, so a change of a single word always
// changes the hash.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <span>

namespace loomstone {

struct WordHash {
  std::uint64_t sum = 0xcbf29ce484222325u;

  void add(std::uint64_t word) {
    sum = (sum ^ word) * 0x100000001b3u;
    sum ^= sum >> 32;
  }
};

// Returns the hash of `bytes`, read as words of eight bytes. Zeros complete the last word.
inline std::uint64_t checksum_of(std::span<const unsigned char> bytes) {
  WordHash hash;
  for (std::size_t at = 0; at < bytes.size(); at += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data() + at, std::min<std::size_t>(8, bytes.size() - at));
    hash.add(word);
  }
  return hash.sum;
}

}  // namespace loomstone
