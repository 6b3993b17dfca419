// Rows that ranks must exchange before a product: those of a fixed block pattern, and those of the
// terms of one solve.
#pragma once

#include "core/linalg/block_matrix.h"
#include "core/linalg/extra_terms.h"
#include "core/parallel/row_layout.h"

namespace loomstone {

// Rows that owned rows of `matrix` are coupled to. Both ranks derive it from the pattern, without
// communication.
Halo matrix_halo(const BlockMatrix& matrix, const RowLayout& layout);

// The same plus the rows that terms couple; every rank knows all terms.
Halo with_term_rows(const Halo& halo, const ExtraTerms& terms, const RowLayout& layout);

}  // namespace loomstone
