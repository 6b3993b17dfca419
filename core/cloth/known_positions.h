// Recognises the positions for which results of a rank's elements are known. Only the rows that
// these elements read are stored and compared.
#pragma once

#include <cstring>
#include <utility>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/types.h"
#include "core/parallel/shared_work.h"

namespace loomstone {

class KnownPositions {
 public:
  KnownPositions() = default;
  // The elements read the range `rows` and the rows in `others`.
  KnownPositions(IndexRange rows, std::vector<Index> others)
      : rows_(rows), others_(std::move(others)) {}

  // Returns whether, in the rows that the elements read, x has the same bits as the argument of the
  // last call of set(). Returns false before the first call of set(), and after forget() until
  // set() is called again.
  bool at(const Points& x) const {
    if (!known_) return false;
    const Index n = rows_.end - rows_.begin;
    if (!same(x, rows_.begin, 0, n)) return false;
    for (std::size_t i = 0; i < others_.size(); ++i)
      if (!same(x, others_[i], n + static_cast<Index>(i), 1)) return false;
    return true;
  }
  void set(const Points& x) {
    const Index n = rows_.end - rows_.begin;
    x_.resize(n + static_cast<Index>(others_.size()), 3);
    x_.topRows(n) = x.middleRows(rows_.begin, n);
    for (std::size_t i = 0; i < others_.size(); ++i)
      x_.row(n + static_cast<Index>(i)) = x.row(others_[i]);
    known_ = true;
  }
  void forget() { known_ = false; }
  std::size_t bytes() const { return bytes_of(others_, x_); }

 private:
  // Returns whether n rows of x, beginning with `row`, have the same bits as n rows of x_,
  // beginning with `place`.
  bool same(const Points& x, Index row, Index place, Index n) const {
    const auto at = [](const Points& table, Index i) {
      return table.data() + 3 * static_cast<std::size_t>(i);
    };
    return std::memcmp(at(x, row), at(x_, place),
                       3 * sizeof(double) * static_cast<std::size_t>(n)) == 0;
  }

  IndexRange rows_;
  std::vector<Index> others_;
  Points x_;  // positions of rows_, then of others_ [m]
  bool known_ = false;
};

}  // namespace loomstone
