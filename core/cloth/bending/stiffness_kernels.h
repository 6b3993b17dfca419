// SIMD kernels that assemble the bending stiffness, which is the sum of q_ef u_e u_f^T over pairs
// of hinges (e, f). u_e is the gradient of the angle of hinge e. The stencil of e contains the
// vertices of all hinges f that are paired with e.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/types.h"

namespace loomstone::stiffness {

struct Tables {
  const Index* pair_start;     // (hinges + 1) first pair of each hinge e
  const Index* pair_hinge;     // (pairs) second hinge f of each pair (e, f)
  const std::uint8_t* place;   // (pairs x 4) indices of the vertices of f in the stencil of e
  const Index* stencil_start;  // (hinges + 1) start of the stencil of each hinge
  const double* q;             // (pairs) coefficient q_ef of u_e u_f^T in the stiffness [N m]
  // (hinges x 4 x 4) Gradient u of the hinge angle with respect to each of the four vertices of the
  // hinge [rad/m]. The fourth component of each gradient is 0.
  const double* gradient;
};

// Computes the moment gradients of the n hinges e in `list`. The moment gradient of e is the sum of
// q_ef u_f over all hinges f that are paired with e. For one listed hinge after another, `out` gets
// four doubles for each vertex of the hinge's stencil: the three components of the moment gradient
// with respect to this vertex, and 0.
void moment_gradients(const Tables& tables, const Index* list, Index n, double* out);

// One row of 3 x 3 blocks of the stiffness matrix, and the hinges that contribute to it.
struct Row {
  const Index* items;    // (n_items) 4 e + j: the row's vertex is the j-th vertex of hinge e
  const Index* offsets;  // (n_items) start of e's data in `moments`, in units of 4 doubles
  Index n_items;
  const Index* block;  // block index in the row, for each stencil vertex of each item's hinge
  Index n_blocks;
};

// For every vertex of the stencil of each item's hinge, adds scale * u m^T to the block of this
// vertex in `values` (n_blocks x 9, column-major). u is the gradient of the hinge angle with
// respect to the row's vertex, and m is the moment gradient of the hinge with respect to the vertex
// of the stencil. `moments` is the output of moment_gradients(), and `sums` is scratch memory of
// row_scratch(n_blocks) doubles.
void add_row(const Tables& tables, const Row& row, const double* moments, double scale,
             double* sums, double* values);
inline std::size_t row_scratch(Index n_blocks) { return 16 * static_cast<std::size_t>(n_blocks); }

}  // namespace loomstone::stiffness
