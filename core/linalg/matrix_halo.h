// Rows that ranks must exchange before a matrix-vector product, because a fixed block pattern or
// the terms of one solve couple them to rows of other ranks.
#pragma once

#include "core/linalg/block_matrix.h"
#include "core/linalg/extra_terms.h"
#include "core/parallel/row_layout.h"

namespace loomstone {

// Returns the halo of this rank: the rows that `matrix` couples across ranks. Each rank derives its
// halo from the pattern, without communication.
Halo matrix_halo(const BlockMatrix& matrix, const RowLayout& layout);

// Returns the halo of `rank` for given ranges of rows: rank i owns the rows [starts[i],
// starts[i + 1]).
Halo halo_of_ranges(const BlockMatrix& matrix, const std::vector<Index>& starts, int rank);

// Returns `halo` extended by the rows that `terms` (may be null) couple across ranks. Every rank
// has all terms that act on its rows, so no communication is needed.
Halo with_term_rows(const Halo& halo, const ExtraTerms* terms, const RowLayout& layout);

}  // namespace loomstone
