// Extra terms of one solve, applied without a matrix: each term computes its force once, then each
// row gathers from its terms in ascending order, so that no two threads write the same slot. What
// an iteration reads of a term is stored together.
#pragma once

#include <algorithm>
#include <vector>

#include "core/linalg/extra_terms.h"
#include "core/parallel/row_layout.h"
#include "core/parallel/team.h"

namespace loomstone {

class TermRows {
 public:
  // Copies the terms (may be null) that touch an owned row; `scale` multiplies every H.
  void build(const ExtraTerms* terms, double scale, const RowLayout& layout);
  bool empty() const { return hessians_.empty(); }
  bool touches(Index row) const { return !empty() && row_start_[row + 1] > row_start_[row]; }
  // Calls body(row) on the owned rows of [begin, end) that terms touch, ascending.
  template <class Body>
  void for_touched(Index begin, Index end, Body&& body) const {
    for (auto row = std::lower_bound(touched_.begin(), touched_.end(), begin);
         row != touched_.end() && *row < end; ++row)
      body(*row);
  }

  // Force of every term that touches an owned row, at x (4 numbers a row).
  template <class Scalar>
  void evaluate(const Team& team, const Scalar* x);
  // sum J^T force over the terms of an owned row.
  Vec3 force(Index row) const;
  // sum J^T (scale H) J over the terms of a row.
  Mat3 diagonal(Index row) const;

 private:
  // An entry of a term; most have no arm.
  struct Part {
    Index row, arm;  // arm: place in arms_, -1 for none
    double weight;
  };
  // The part of a term that touches a row, with its arm and weight: rows read their slots in order.
  struct Slot {
    Index term, arm;
    double weight;
  };
  TermEntry entry(Index row, Index arm, double weight) const {
    return {row, arm >= 0, weight, arm >= 0 ? arms_[arm] : Vec3(Vec3::Zero())};
  }

  double scale_ = 0.0;
  std::vector<Mat3> hessians_;     // (terms that touch an owned row, ascending)
  std::vector<Index> part_start_;  // (terms + 1)
  std::vector<Part> parts_;
  std::vector<Vec3> arms_, forces_;
  std::vector<Index> row_start_;  // (rows + 1) into slots_
  std::vector<Slot> slots_;       // of owned rows, ascending term
  std::vector<Index> touched_;    // owned rows with slots, ascending
};

}  // namespace loomstone
