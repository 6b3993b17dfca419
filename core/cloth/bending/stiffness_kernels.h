// SIMD kernels that assemble the bending stiffness.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/types.h"

namespace loomstone::stiffness {

struct Tables {
  const Index* pair_start;     // (hinges + 1)
  const Index* pair_hinge;     // (pairs) second hinge f of each pair (e, f)
  const std::uint8_t* place;   // (pairs x 4) positions of the vertices of f in the stencil of e
  const Index* stencil_start;  // (hinges + 1)
  const double* q;             // (pairs) q_ef [N m]
  const double* gradient;      // (hinges x 4 x 4) u, fourth component zero [rad/m]
};

// Computes sum_f q_ef u_f at each vertex of the stencil of every listed hinge e. The output has 4
// doubles per vertex, hinge by hinge.
void moment_gradients(const Tables& tables, const Index* list, Index n, double* out);

// Hinges that contribute to one row of blocks.
struct Row {
  const Index* items;    // (n_items) 4 e + j: the row's vertex is the j-th vertex of hinge e
  const Index* offsets;  // (n_items) start of the hinge's moment gradients, counted in vertices
  Index n_items;
  const Index* block;  // block index in the row, for each vertex of each item's stencil
  Index n_blocks;
};

// Adds scale * sum over items of u m^T to `values` (n_blocks x 9). `sums` is scratch memory of
// row_scratch(n_blocks) doubles.
void add_row(const Tables& tables, const Row& row, const double* moments, double scale,
             double* sums, double* values);
inline std::size_t row_scratch(Index n_blocks) { return 16 * static_cast<std::size_t>(n_blocks); }

}  // namespace loomstone::stiffness
