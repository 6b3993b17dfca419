// Arbitrary-precision integers for exact continuous collision detection. They are stored as sign
// and magnitude and have the operations that low-degree polynomials need.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace loomstone {

class Integer {
 public:
  Integer() = default;
  Integer(std::int64_t value) : negative_(value < 0) {
    if (value != 0)
      limbs_.push(value < 0 ? -static_cast<std::uint64_t>(value)
                            : static_cast<std::uint64_t>(value));
  }

  int sign() const { return limbs_.size() == 0 ? 0 : negative_ ? -1 : 1; }

  // Returns this integer times 2^bits.
  Integer shifted(unsigned bits) const {
    Integer result;
    result.negative_ = negative_;
    if (limbs_.size() == 0) return result;
    for (unsigned i = 0; i < bits / 64; ++i) result.limbs_.push(0);
    Wide carry = 0;
    for (std::size_t i = 0; i < limbs_.size(); ++i) {
      carry |= static_cast<Wide>(limbs_[i]) << (bits % 64);
      result.limbs_.push(static_cast<std::uint64_t>(carry));
      carry >>= 64;
    }
    if (carry != 0) result.limbs_.push(static_cast<std::uint64_t>(carry));
    return result;
  }

  friend Integer operator+(const Integer& a, const Integer& b) { return sum(a, b, b.negative_); }
  friend Integer operator-(const Integer& a, const Integer& b) { return sum(a, b, !b.negative_); }

  friend Integer operator*(const Integer& a, const Integer& b) {
    Integer result;
    const std::size_t n = a.limbs_.size(), m = b.limbs_.size();
    if (n == 0 || m == 0) return result;
    result.negative_ = a.negative_ != b.negative_;
    for (std::size_t i = 0; i < n + m; ++i) result.limbs_.push(0);
    for (std::size_t i = 0; i < n; ++i) {
      std::uint64_t carry = 0;
      for (std::size_t j = 0; j < m; ++j) {
        const Wide product =
            static_cast<Wide>(a.limbs_[i]) * b.limbs_[j] + result.limbs_[i + j] + carry;
        result.limbs_[i + j] = static_cast<std::uint64_t>(product);
        carry = static_cast<std::uint64_t>(product >> 64);
      }
      result.limbs_[i + m] = carry;
    }
    result.limbs_.trim();
    return result;
  }

 private:
  __extension__ using Wide = unsigned __int128;

  // Limbs from the lowest to the highest. After each arithmetic operation, the highest limb is not
  // zero. Up to `in_place` limbs are stored inline. If more are pushed, all move to the heap.
  class Limbs {
   public:
    Limbs() {}
    Limbs(const Limbs& other) : size_(other.size_), heap_(other.heap_) { copy(other); }
    Limbs(Limbs&& other) noexcept : size_(other.size_), heap_(std::move(other.heap_)) {
      copy(other);
    }
    Limbs& operator=(const Limbs& other) {
      size_ = other.size_;
      heap_ = other.heap_;
      copy(other);
      return *this;
    }
    Limbs& operator=(Limbs&& other) noexcept {
      size_ = other.size_;
      heap_ = std::move(other.heap_);
      copy(other);
      return *this;
    }

    std::size_t size() const { return size_; }
    std::uint64_t operator[](std::size_t i) const { return heap_.empty() ? place_[i] : heap_[i]; }
    std::uint64_t& operator[](std::size_t i) { return heap_.empty() ? place_[i] : heap_[i]; }
    void push(std::uint64_t limb) {
      if (heap_.empty() && size_ < in_place) {
        place_[size_++] = limb;
        return;
      }
      if (heap_.empty()) heap_.assign(place_, place_ + size_);
      heap_.resize(size_);
      heap_.push_back(limb);
      ++size_;
    }
    void trim() {
      while (size_ > 0 && (*this)[size_ - 1] == 0) --size_;
    }

   private:
    static constexpr std::size_t in_place = 16;
    void copy(const Limbs& other) {
      if (heap_.empty()) std::copy(other.place_, other.place_ + std::min(size_, in_place), place_);
    }

    std::size_t size_ = 0;
    std::uint64_t place_[in_place];
    std::vector<std::uint64_t> heap_;
  };

  static bool less(const Limbs& a, const Limbs& b) {
    if (a.size() != b.size()) return a.size() < b.size();
    for (std::size_t i = a.size(); i-- > 0;)
      if (a[i] != b[i]) return a[i] < b[i];
    return false;
  }

  // Returns a + b, where `b_negative` replaces the sign of b.
  static Integer sum(const Integer& a, const Integer& b, bool b_negative) {
    Integer result;
    const bool add = a.negative_ == b_negative, swapped = less(a.limbs_, b.limbs_);
    const Limbs& large = swapped ? b.limbs_ : a.limbs_;
    const Limbs& small = swapped ? a.limbs_ : b.limbs_;
    result.negative_ = swapped ? b_negative : a.negative_;
    std::uint64_t carry = 0;
    for (std::size_t i = 0; i < large.size(); ++i) {
      const std::uint64_t other = i < small.size() ? small[i] : 0;
      const Wide value = add ? static_cast<Wide>(large[i]) + other + carry
                             : static_cast<Wide>(large[i]) - other - carry;
      result.limbs_.push(static_cast<std::uint64_t>(value));
      carry = static_cast<std::uint64_t>(value >> 64) & 1u;
    }
    if (carry != 0) result.limbs_.push(carry);
    result.limbs_.trim();
    return result;
  }

  bool negative_ = false;
  Limbs limbs_;
};

}  // namespace loomstone
