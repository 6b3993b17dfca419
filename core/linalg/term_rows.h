// Extra terms of one solve, applied without a matrix: every term works out its force once, then every row gathers from its
// terms in ascending order (no two threads write the same slot).
#pragma once

#include <vector>

#include "core/linalg/extra_terms.h"
#include "core/parallel/row_layout.h"
#include "core/parallel/team.h"

namespace loomstone {

class TermRows {
 public:
  // `terms` (may be null) must outlive the solve; `scale` multiplies every H.
  void build(const ExtraTerms* terms, double scale, const RowLayout& layout);
  bool empty() const { return involved_.empty(); }
  bool touches(Index row) const { return !empty() && row_start_[row + 1] > row_start_[row]; }

  // Force of every term that touches an owned row, at x (4 numbers a row).
  template <class Scalar>
  void evaluate(const Team& team, const Scalar* x);
  // sum J^T force over the terms of an owned row.
  Vec3 force(Index row) const;
  // sum J^T (scale H) J over the terms of a row.
  Mat3 diagonal(Index row) const;

 private:
  struct Slot {
    Index term;
    int entry;
  };
  const ExtraTerms* terms_ = nullptr;
  double scale_ = 0.0;
  std::vector<Index> involved_;           // terms that touch an owned row, ascending
  std::vector<Index> row_start_;          // (rows + 1) into slots_
  std::vector<Slot> slots_;               // of owned rows, ascending term
  std::vector<Vec3> forces_;              // (terms)
};

}  // namespace loomstone
