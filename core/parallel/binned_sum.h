// Sum whose bits do not depend on the order in which numbers are added [Ahrens2020]. Numbers are
// split into parts of 32 bits at fixed powers of two. The parts between the same two powers are
// added exactly, as integers, in one bin, and only the four highest bins are kept. Ranks can
// therefore add their sums in any order.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <limits>

namespace loomstone {

class BinnedSum {
 public:
  // Adds a number. At most 2^30 numbers may be added to a sum, including those of added sums.
  void add(double number);
  // Adds all numbers of another sum.
  void add(const BinnedSum& other);
  // Returns the sum. For n numbers of magnitude up to m, the error is at most n m 2^-95 plus one
  // rounding. The result is NaN if a number is NaN or if there are infinities of both signs.
  // Otherwise, it is infinite if a number is infinite or if the sum is beyond the range of double.
  double value() const;

 private:
  static constexpr int n_bins = 4, bits_per_bin = 32;
  enum Special : std::int32_t { NotANumber = 1, PlusInfinity = 2, MinusInfinity = 4 };

  // Makes `top`, which must not be lower than top_, the position of the highest bin. Bins that are
  // then below the lowest position are dropped.
  void raise(std::int32_t top);

  // Bin i is at position top_ - i. A bin at position p counts multiples of 2^(32 p - 1074).
  std::array<std::int64_t, n_bins> bins_{};
  std::int32_t top_ = 0;
  std::int32_t special_ = 0;  // bits of Special: kinds of added numbers that are not finite
};

inline void BinnedSum::raise(std::int32_t top) {
  const int shift = top - top_;
  if (shift == 0) return;
  for (int i = n_bins - 1; i >= 0; --i) bins_[i] = i >= shift ? bins_[i - shift] : 0;
  top_ = top;
}

inline void BinnedSum::add(double number) {
  const auto bits = std::bit_cast<std::uint64_t>(number);
  const auto exponent = static_cast<int>(bits >> 52 & 0x7ff);
  std::uint64_t mantissa = bits & ((std::uint64_t{1} << 52) - 1);
  const bool negative = bits >> 63 != 0;
  if (exponent == 0x7ff) {
    special_ |= mantissa != 0 ? NotANumber : negative ? MinusInfinity : PlusInfinity;
    return;
  }
  if (exponent > 0) mantissa |= std::uint64_t{1} << 52;
  if (mantissa == 0) return;
  // The number is mantissa 2^(place - 1074). Its parts belong to positions `low` to `low` + 2.
  const int place = exponent > 0 ? exponent - 1 : 0;
  const int low = place / bits_per_bin, shift = place % bits_per_bin;
  const std::uint64_t first = (mantissa & 0xffffffffu) << shift,
                      second = (mantissa >> 32 << shift) + (first >> 32);
  const std::uint64_t parts[3] = {first & 0xffffffffu, second & 0xffffffffu, second >> 32};
  const int highest = parts[2] != 0 ? 2 : parts[1] != 0 ? 1 : 0;
  if (low + highest > top_) raise(low + highest);
  for (int part = 0; part <= highest; ++part) {
    const int bin = top_ - (low + part);
    if (bin >= n_bins) continue;
    const auto value = static_cast<std::int64_t>(parts[part]);
    bins_[bin] += negative ? -value : value;
  }
}

inline void BinnedSum::add(const BinnedSum& other) {
  if (other.top_ > top_) raise(other.top_);
  const int shift = top_ - other.top_;
  for (int i = shift; i < n_bins; ++i) bins_[i] += other.bins_[i - shift];
  special_ |= other.special_;
}

}  // namespace loomstone
