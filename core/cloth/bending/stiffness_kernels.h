// The arithmetic of assembling the bending stiffness.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/types.h"

namespace loomstone::stiffness {

struct Tables {
  const Index* pair_start;     // (hinges + 1)
  const Index* pair_hinge;     // (pairs) second hinge f
  const std::uint8_t* place;   // (pairs x 4) where the vertices of f lie in the stencil of e
  const Index* stencil_start;  // (hinges + 1)
  const double* q;             // (pairs) q_ef [N m]
  const double* gradient;      // (hinges x 4 x 4) u, fourth component zero [rad/m]
};

// For every listed hinge e: sum_f q_ef u_f at each vertex of its stencil (4 doubles each), one
// hinge after another.
void moment_gradients(const Tables& tables, const Index* list, Index n, double* out);

// The hinges of one row of blocks.
struct Row {
  const Index* items;    // (n_items) 4 hinge + j: the row's vertex is the hinge's j-th
  const Index* offsets;  // (n_items) where the hinge's moment gradients begin, in vertices
  Index n_items;
  const Index* block;  // block in the row of each vertex of each item's stencil
  Index n_blocks;
};

// values (n_blocks x 9) += scale sum over items of u m^T. sums: scratch of row_scratch(n_blocks)
// doubles.
void add_row(const Tables& tables, const Row& row, const double* moments, double scale,
             double* sums, double* values);
inline std::size_t row_scratch(Index n_blocks) { return 16 * static_cast<std::size_t>(n_blocks); }

}  // namespace loomstone::stiffness
