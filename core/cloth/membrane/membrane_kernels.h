// SIMD kernels of the membrane, in batches of eight triangles. Equation numbers are those of
// [Thomaszewski2010].
#pragma once

#include <cstdint>

#include "core/base/types.h"
#include "core/cloth/material/jacobian_terms.h"

namespace loomstone::membrane {

// Entries per batch in each table; mode_stride: entries per mode of a batch.
inline constexpr int corner_stride = 3 * 8, gradient_stride = 6 * 8, constant_stride = 7 * 8;
inline constexpr int force_stride = 9 * 8, block_stride = 27 * 8, strain_stride = 5 * 8;
inline constexpr int phase_stride = 6 * 8, neglected_stride = 3 * 8;
inline constexpr int mode_stride = 8 * 8, limit_stride = 3 * mode_stride, entered_stride = 6;
// In the block table of a batch, the block of corner pair p in lane l begins at 72 p + 9 l.
inline constexpr int pair_stride = 9 * 8, lane_stride = 9;

// Tables of all batches, and the averaging time of viscous forces. The kernels write to `entered`
// and to no other table.
struct Tables {
  const Index* corners;     // (batches x 3 x 8) vertices
  const double* gradients;  // (batches x 6 x 8) dN0x dN0y dN1x dN1y dN2x dN2y [1/m]
  const double* constants;  // (batches x 7 x 8) area [m^2], fields of MembraneConstants
  // Near strain limits, stiff phases add a linear function of the Green strain E to the stresses
  // S11, S22 and S12.
  const double* phase = nullptr;           // (batches x 6 x 8) slopes, then values at E = 0 [N/m]
  const std::uint8_t* in_phase = nullptr;  // (batches) 0: nothing is added
  // (batches x 3 x 8 x 8) limited modes, with the fields of LimitMode in their order; may be null.
  const double* limits = nullptr;
  // (batches x 3 x 2) Bit masks for the second and the third phase of each mode; may be null.
  // forces() sets the bits of the lanes whose mode has entered the phase. A mode in the third phase
  // has both bits set.
  std::uint8_t* entered = nullptr;
  // Time over which viscous forces average the strain rate [s]; 0: no average. The average assumes
  // that the cloth has moved to x at the constant velocity v during this time.
  double rate_time = 0.0;
};

// Computes the forces (batches x 3 corners x 3 x 8): the negative energy gradient (2.33) and, if v
// is given, the viscous force (2.24, 2.25).
void forces(const Tables& tables, const Index* batches, Index n, const double* x, const double* v,
            double* out);

// Computes the Jacobian blocks (2.35) for corner pairs (i, k) = (0, 1), (1, 2), (2, 0),
// column-major. The blocks of the n listed batches follow one another.
void blocks(const Tables& tables, const Index* batches, Index n, const double* x,
            JacobianTerms terms, double* out);

// Sets n rows of a block matrix. Each off-diagonal block is the sum of one element block and the
// transpose of another; either may be a block of zeros. `sources` (2 per block) contains the
// offsets of both in `elements`. The diagonal block is minus the symmetric part of the sum of the
// other blocks in its row, because a translation causes no strain. row_start (n + 1) and diagonal
// (n) are indices of blocks in `values`.
void rows(Index n, const Index* row_start, const Index* diagonal, const Index* sources,
          const double* elements, double* values);

struct BatchRange {
  Index first, n;
};
// Computes what a linear model of the strain neglects over a displacement u = end - start (n x 3
// each), or u = end if start is null. If E is the Green strain, F the deformation gradient at
// positions x, and dF the gradient of u,
//   E(x + u) = E(x) + sym(F^T dF) + 1/2 dF^T dF
// holds exactly. The output for each triangle is the largest eigenvalue of 1/2 dF^T dF, the
// membrane energy of that strain, and the membrane energy at `end`, which is meaningful only if
// `end` contains positions. The output has one entry (3 x 8) per batch of the range.
void neglected_strains(const Tables& tables, BatchRange batches, const double* start,
                       const double* end, double* out);

// Computes E11, E22, E12, the energy and the largest principal stretch of each triangle
// (batches x 5 x 8).
void strains(const Tables& tables, const Index* batches, Index n, const double* x, double* out);

}  // namespace loomstone::membrane
