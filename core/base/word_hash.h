// FNV-1a hash over words of eight bytes, with an additional shift that mixes high bits into low
// ones. The hash is an invertible function of each word, so a change of a single word always
// changes the hash.
#pragma once

#include <cstdint>

namespace loomstone {

struct WordHash {
  std::uint64_t sum = 0xcbf29ce484222325u;

  void add(std::uint64_t word) {
    sum = (sum ^ word) * 0x100000001b3u;
    sum ^= sum >> 32;
  }
};

}  // namespace loomstone
