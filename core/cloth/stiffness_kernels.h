// The arithmetic of the bending stiffness.
#pragma once

#include <cstdint>

#include "core/base/types.h"

namespace loomstone::stiffness {

inline constexpr int block_stride = 16;  // doubles a block takes while it is summed; the first nine count

struct Tables {
  const Index* pair_start;    // (hinges + 1)
  const Index* pair_hinge;    // (pairs) second hinge f
  const std::uint8_t* place;  // (pairs x 4) where the vertices of f lie in the stencil of e
  const Index* stencil_start; // (hinges + 1)
  const double* q;            // (pairs) q_ef [N m]
  const double* gradient;     // (hinges x 4 x 4) u, fourth component zero [rad/m]
};

// For every hinge e listed: sum_f q_ef u_f at each vertex of its stencil (4 doubles each), one after another.
void moment_gradients(const Tables& tables, const Index* list, Index n, double* out);

// blocks[block[s]] += u m_s^T, column-major, for s in [0, n). One double4 each; eight doubles of m_s are read.
void add_products(const double* u, const double* m, const Index* block, Index n, double* blocks);

}  // namespace loomstone::stiffness
