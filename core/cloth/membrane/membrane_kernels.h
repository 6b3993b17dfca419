// The element arithmetic of the membrane on batches of eight triangles.
#pragma once

#include <cstdint>

#include "core/base/types.h"

namespace loomstone::membrane {

// Doubles a batch takes in each table.
inline constexpr int corner_stride = 3 * 8, gradient_stride = 6 * 8, constant_stride = 7 * 8;
inline constexpr int force_stride = 9 * 8, block_stride = 27 * 8, strain_stride = 5 * 8;
inline constexpr int phase_stride = 6 * 8;
// Blocks of a batch: those of pair p of lane l begin at 72 p + 9 l.
inline constexpr int pair_stride = 9 * 8, lane_stride = 9;

// Constant tables of all batches.
struct Tables {
  const Index* corners;           // (batches x 3 x 8) vertices
  const double* gradients;        // (batches x 6 x 8) dN0x dN0y dN1x dN1y dN2x dN2y [1/m]
  const double* constants;        // (batches x 7 x 8) area, a11, a22, a12, g, lambda_d, mu_d
  const double* phase = nullptr;  // (batches x 6 x 8) slope, then stress at E = 0, of what is added
                                  // to S11, S22, S12; or null
  const std::uint8_t* in_phase = nullptr;  // (batches) 0: nothing is added
};

// forces (x 3 corners x 3): minus (2.33); with v also minus the viscous force (2.24, 2.25).
void forces(const Tables& tables, const Index* batches, Index n, const double* x, const double* v,
            double* out);

// Blocks d f_i / d x_k (2.35) for (i, k) = (0, 1), (1, 2), (2, 0), column-major; elastic part times
// scale_k, the geometric term with the positive part of S where `positive`; viscous part times
// scale_d. The n batches listed, one after another.
void blocks(const Tables& tables, const Index* batches, Index n, const double* x, bool positive,
            double scale_k, double scale_d, double* out);

// Rows of a block matrix: each block is the sum of an element block and the transpose of another
// one (sources: where they begin in `elements`, two a block), the diagonal block minus the
// symmetric part of the sum of the others, since a translation strains nothing. row_start (n + 1)
// and diagonal (n) count blocks from the first of the rows.
void rows(Index n, const Index* row_start, const Index* diagonal, const Index* sources,
          const double* elements, double* values);

// E11, E22, E12, energy, largest principal stretch.
void strains(const Tables& tables, const Index* batches, Index n, const double* x, double* out);

}  // namespace loomstone::membrane
