// Conversion of a binned sum to a number.
#include "core/parallel/binned_sum.h"

#include <algorithm>
#include <cmath>

namespace loomstone {

double BinnedSum::value() const {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  if ((special_ & NotANumber) != 0 || (special_ & PlusInfinity && special_ & MinusInfinity))
    return std::numeric_limits<double>::quiet_NaN();
  if (special_ != 0) return special_ == PlusInfinity ? infinity : -infinity;

  // The sum is high 2^64 + low in units of the lowest bin, with 0 <= low < 2^64.
  const __int128 lower = (static_cast<__int128>(bins_[2]) << bits_per_bin) + bins_[3];
  __int128 high = (static_cast<__int128>(bins_[0]) << bits_per_bin) + bins_[1] + (lower >> 64);
  auto low = static_cast<std::uint64_t>(lower);
  const bool negative = high < 0;
  if (negative) {
    high = -high - (low != 0 ? 1 : 0);
    low = -low;
  }
  int exponent = bits_per_bin * (top_ - (n_bins - 1)) - 1074;
  // Shifts the sum to the right until it fits into 64 bits. The lowest bit is also set if a lost
  // bit was set, so that the conversion to double rounds correctly.
  auto top = static_cast<std::uint64_t>(high >> 64);
  auto middle = static_cast<std::uint64_t>(high);
  while (top != 0 || middle != 0) {
    const int shift = top != 0 ? 64 : 64 - std::countl_zero(middle);
    const std::uint64_t lost = shift == 64 ? low : low & ((std::uint64_t{1} << shift) - 1);
    low = shift == 64 ? middle : low >> shift | middle << (64 - shift);
    middle = shift == 64 ? top : 0;
    top = 0;
    low |= lost != 0 ? 1 : 0;
    exponent += shift;
  }
  const double size = std::ldexp(static_cast<double>(low), exponent);
  return negative ? -size : size;
}

}  // namespace loomstone
