// Extra terms of one solve, applied without an assembled matrix. In a matrix-vector product, the
// force of each term is computed once. Each row then adds up the forces of its own terms, so no two
// threads write to the same location. A row adds forces in the order of the terms. Terms are copied
// to compact arrays.
#pragma once

#include <algorithm>
#include <vector>

#include "core/base/aligned.h"
#include "core/base/bytes.h"
#include "core/linalg/extra_terms.h"
#include "core/parallel/row_layout.h"
#include "core/parallel/team.h"

namespace loomstone {

class TermRows {
 public:
  // Copies those of `terms` (may be null) that act on owned rows. In this class, J and H are those
  // of core/linalg/extra_terms.h. `scale` multiplies the matrix H of every term.
  void build(const ExtraTerms* terms, double scale, const RowLayout& layout);
  bool empty() const { return hessians_.empty(); }
  bool touches(Index row) const { return !empty() && row_start_[row + 1] > row_start_[row]; }
  // Calls body(row) on the owned rows of [begin, end) on which terms act, in ascending order.
  template <class Body>
  void for_touched(Index begin, Index end, Body&& body) const {
    for (auto row = std::lower_bound(touched_.begin(), touched_.end(), begin);
         row != touched_.end() && *row < end; ++row)
      body(*row);
  }

  // Computes the force f = scale H sum J x of every copied term. x has 4 numbers per row.
  template <class Scalar>
  void evaluate(const Team& team, const Scalar* x);
  // Returns the sum of J^T f over the terms of an owned row, with f from the last evaluate().
  Vec3 force(Index row) const;
  // Returns the sum of scale J^T H J over the terms of an owned row.
  Mat3 diagonal(Index row) const;

  std::size_t bytes() const {
    return bytes_of(hessians_, part_start_, parts_, arms_, scaled_, forces_, row_start_, slots_) +
           bytes_of(touched_);
  }

 private:
  // An entry of a term. Only entries of rotation rows have an arm (see TermEntry).
  struct Part {
    Index row, arm;  // arm: index in arms_, or -1
    double weight;
  };
  // A term's entry in a given row. Each row reads its slots in the order of the terms.
  struct Slot {
    Index term, arm;
    double weight;
  };
  TermEntry entry(Index row, Index arm, double weight) const {
    return {row, arm >= 0, weight, arm >= 0 ? arms_[arm] : Vec3(Vec3::Zero())};
  }
  // Computes the forces of terms [begin, end). Lanes only selects the instruction set (simd.h).
  template <class Lanes, class Scalar>
  static void find_forces(TermRows& rows, Index begin, Index end, const Scalar* x);

  double scale_ = 0.0;
  std::vector<Mat3> hessians_;     // (copied terms) H of each term
  std::vector<Index> part_start_;  // (terms + 1) first part of each term
  std::vector<Part> parts_;
  std::vector<Vec3> arms_;
  AlignedDoubles scaled_;         // (terms x 3 x 4) scale times H, with row 2 rotated; see build()
  AlignedDoubles forces_;         // (terms x 4) components of the force, and a zero
  std::vector<Index> row_start_;  // (rows + 1) first slot of each row
  std::vector<Slot> slots_;       // slots of owned rows, sorted by row and term
  std::vector<Index> touched_;    // owned rows with slots, in ascending order
};

}  // namespace loomstone
