// Rows that ranks must exchange before a product: of a fixed block pattern, and of terms that come
// and go.
#pragma once

#include "core/linalg/block_matrix.h"
#include "core/linalg/extra_terms.h"
#include "core/parallel/row_layout.h"

namespace loomstone {

// Rows that owned rows of `matrix` are coupled to. Both sides derive it from the pattern, without
// talking.
Halo matrix_halo(const BlockMatrix& matrix, const RowLayout& layout);

// The same with the rows that terms couple added; every rank knows all terms.
Halo with_term_rows(const Halo& halo, const ExtraTerms& terms, const RowLayout& layout);

}  // namespace loomstone
