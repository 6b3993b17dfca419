// Writes numbers to a sequence of bytes and reads them back, in the byte order of the machine.
#pragma once

#include <cstring>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/base/message.h"

namespace loomstone {

class ByteWriter {
 public:
  explicit ByteWriter(std::size_t expected = 0) : bytes_(expected) {}

  template <class Number>
  void write(Number value) {
    write_all(&value, 1);
  }
  template <class Number>
  void write_all(const Number* values, std::size_t n) {
    static_assert(std::is_arithmetic_v<Number>);
    const std::size_t more = n * sizeof(Number);
    if (size_ + more > bytes_.size()) bytes_.resize(2 * bytes_.size() + more + 4096);
    std::memcpy(bytes_.data() + size_, values, more);
    size_ += more;
  }
  std::vector<unsigned char> take() {
    bytes_.resize(size_);
    return std::move(bytes_);
  }

 private:
  std::vector<unsigned char> bytes_;
  std::size_t size_ = 0;
};

class ByteReader {
 public:
  explicit ByteReader(const std::vector<unsigned char>& bytes) : bytes_(bytes) {}

  template <class Number>
  Number read() {
    static_assert(std::is_arithmetic_v<Number>);
    require(bytes_.size() - position_ >= sizeof(Number));
    Number value;
    std::memcpy(&value, bytes_.data() + position_, sizeof(Number));
    position_ += sizeof(Number);
    return value;
  }
  bool at_end() const { return position_ == bytes_.size(); }

  void require(bool fits) const {
    if (fits) return;
    fail<InvalidInput>(
        "rigid state: the saved contact points must be those of this scene, got bytes that do not "
        "fit; load the state with the scene from which it was saved");
  }

 private:
  const std::vector<unsigned char>& bytes_;
  std::size_t position_ = 0;
};

}  // namespace loomstone
