// The element arithmetic of the membrane, on batches of eight triangles.
#pragma once

#include <cstdint>

#include "core/base/types.h"
#include "core/cloth/material/jacobian_terms.h"

namespace loomstone::membrane {

// Doubles per batch in each table.
inline constexpr int corner_stride = 3 * 8, gradient_stride = 6 * 8, constant_stride = 7 * 8;
inline constexpr int force_stride = 9 * 8, block_stride = 27 * 8, strain_stride = 5 * 8;
inline constexpr int phase_stride = 6 * 8;
// In the blocks of a batch, that of pair p in lane l begins at 72 p + 9 l.
inline constexpr int pair_stride = 9 * 8, lane_stride = 9;

// Constant tables of all batches.
struct Tables {
  const Index* corners;     // (batches x 3 x 8) vertices
  const double* gradients;  // (batches x 6 x 8) dN0x dN0y dN1x dN1y dN2x dN2y [1/m]
  const double* constants;  // (batches x 7 x 8) area, a11, a22, a12, g, lambda_d, mu_d
  // The stiff phases near strain limits add a linear function of E to S11, S22, S12.
  const double* phase = nullptr;           // (batches x 6 x 8) its slopes, then its values at E = 0
  const std::uint8_t* in_phase = nullptr;  // (batches) 0: nothing is added
};

// Forces (batches x 3 corners x 3 x 8): minus (2.33), and minus the viscous force (2.24, 2.25) if v
// is given.
void forces(const Tables& tables, const Index* batches, Index n, const double* x, const double* v,
            double* out);

// Blocks d f_i / d x_k (2.35) for (i, k) = (0, 1), (1, 2), (2, 0), column-major, of the n listed
// batches, one after another.
void blocks(const Tables& tables, const Index* batches, Index n, const double* x,
            JacobianTerms terms, double* out);

// Rows of a block matrix. Each block is the sum of one element block and the transpose of another;
// `sources` (2 per block) says where they begin in `elements`. The diagonal block is minus the
// symmetric part of the sum of the others, because a translation causes no strain. row_start (n +
// 1) and diagonal (n) count blocks from the first of the rows.
void rows(Index n, const Index* row_start, const Index* diagonal, const Index* sources,
          const double* elements, double* values);

// Per triangle: E11, E22, E12, energy, largest principal stretch.
void strains(const Tables& tables, const Index* batches, Index n, const double* x, double* out);

}  // namespace loomstone::membrane
