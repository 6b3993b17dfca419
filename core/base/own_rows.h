// Tables that store a contiguous range of the rows of a whole table. Rows are addressed by their
// indices in the whole table. In such tables, a rank stores its own rows of forces and of the
// right-hand side of the linear solve.
#pragma once

#include <utility>

#include "core/base/bytes.h"
#include "core/base/types.h"

namespace loomstone {

// A table of the rows [begin, end), with three numbers each.
class OwnRows {
 public:
  OwnRows() = default;
  explicit OwnRows(Points whole) : rows_(std::move(whole)) {}  // contains all rows of a table
  // Sets the range of rows. The values are undefined if the range changes.
  void resize(Index begin, Index end) { begin_ = begin, rows_.resize(end - begin, 3); }
  Index begin() const { return begin_; }
  Index end() const { return begin_ + static_cast<Index>(rows_.rows()); }
  auto row(Index i) { return rows_.row(i - begin_); }
  auto row(Index i) const { return rows_.row(i - begin_); }
  double* data() { return rows_.data(); }  // pointer to row begin()
  const double* data() const { return rows_.data(); }
  // Returns a whole table of n rows, with zeros outside [begin(), end()).
  Points whole(Index n) const {
    Points table = Points::Zero(n, 3);
    table.middleRows(begin_, rows_.rows()) = rows_;
    return table;
  }
  std::size_t bytes() const { return bytes_of(rows_); }

 private:
  Index begin_ = 0;
  Points rows_;
};

// Reference to the rows that a function reads, either in an OwnRows or in a whole table.
class RowsIn {
 public:
  RowsIn(const Points& table)
      : data_(table.data()), begin_(0), end_(static_cast<Index>(table.rows())) {}
  RowsIn(const OwnRows& table) : data_(table.data()), begin_(table.begin()), end_(table.end()) {}
  Index begin() const { return begin_; }
  Index end() const { return end_; }
  double operator()(Index row, Index axis) const { return data_[3 * (row - begin_) + axis]; }
  Eigen::Map<const Eigen::RowVector3d> row(Index i) const {
    return Eigen::Map<const Eigen::RowVector3d>(data_ + 3 * (i - begin_));
  }

 private:
  const double* data_;
  Index begin_, end_;
};

// Reference to the rows that a function writes, either in an OwnRows or in a whole table.
class RowsOut {
 public:
  RowsOut(Points& table) : data_(table.data()) {}
  RowsOut(OwnRows& table) : data_(table.data()), begin_(table.begin()) {}
  double& operator()(Index row, Index axis) const { return data_[3 * (row - begin_) + axis]; }
  Eigen::Map<Eigen::RowVector3d> row(Index i) const {
    return Eigen::Map<Eigen::RowVector3d>(data_ + 3 * (i - begin_));
  }

 private:
  double* data_;
  Index begin_ = 0;
};

}  // namespace loomstone
