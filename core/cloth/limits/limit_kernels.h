// Kernels of strain limiting, for batches of eight triangles (SIMD) or for one triangle.
#pragma once

#include <cstdint>

#include "core/cloth/limits/element_limit.h"

namespace loomstone::limit {

// Tables of all elements. Except for the bounds, they change only if the held vertices change. Slot
// s is lane s % 8 of batch s / 8.
struct Tables {
  const Index* corners;  // (batches x 3 x 8) vertices
  // (batches x 4 x 8) gradients of Element, the only numbers of an Element that check() reads
  const double* gradients;
  const double* numbers;  // (batches x 9 x 8) numbers of Element other than gradients
  // (slots) bit k: corner k may move; two_held is set if only one corner may move; 0: none may move
  const std::uint8_t* moves;
  const Index* bounds_of;  // (batches) index into bounds
  const Bounds* bounds;
  const double* rows;  // (slots x 13) element of each slot, for correct_one(); may be null
};
inline constexpr std::uint8_t two_held = 8;

// The quantity that the kernels limit: the strain at positions x if v is null, and otherwise the
// strain rate of velocities v at positions x.
struct Motion {
  double* x;
  double* v;
  double tolerance;  // smaller excesses are not corrected; unit: 1 for strain, 1/s for strain rate
};

// Corrects the elements of the listed batches, one batch after another. Bit l of corrected[batch]
// is set if lane l was corrected.
void sweep(const Tables& tables, const Motion& motion, const Index* batches, Index n,
           std::uint8_t* corrected);

// Computes the changes of x, or of v, without applying them. For batches with a lane to correct,
// writes the changes at all three corners to `out` (batches x 9 x 8). Sets `corrected` as sweep()
// does.
void corrections(const Tables& tables, const Motion& motion, const Index* batches, Index n,
                 std::uint8_t* corrected, double* out);

// Corrects one element. Returns true if the element was corrected. Requires tables.rows.
bool correct_one(const Tables& tables, const Motion& motion, Index slot);

// Output of check().
struct Violations {
  double* excess;   // (batches) largest excess in the batch; 0: all within bounds
  double* strains;  // (batches x 3 x 8) strains, or strain rates, of batches with an excess
};

// Finds excesses of strain, or of strain rate, in n batches: batches[first] to
// batches[first + n - 1] or, if `batches` is null, the batches first to first + n - 1.
void check(const Tables& tables, const Motion& motion, const Index* batches, Index first, Index n,
           Violations out);

}  // namespace loomstone::limit
