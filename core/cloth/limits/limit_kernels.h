// The element arithmetic of strain limiting, on batches of eight triangles or on one.
#pragma once

#include <cstdint>

#include "core/cloth/limits/element_limit.h"

namespace loomstone::limit {

// Tables that change only with the held vertices. Slot s is lane s % 8 of batch s / 8.
struct Tables {
  const Index* corners;       // (batches x 3 x 8) vertices
  const double* gradients;    // (batches x 4 x 8) the gradients of Element: all that checks read
  const double* numbers;      // (batches x 9 x 8) the other numbers of Element
  const std::uint8_t* moves;  // (slots) bit k: corner k may move; two_held; 0 on empty lanes
  const Index* bounds_of;     // (batches) row of bounds
  const Bounds* bounds;
  const double* rows;  // (slots x 13) Element slot by slot, for correct_one(); may be null
};
inline constexpr std::uint8_t two_held = 8;

// If v is null, the strain of positions x is limited, else the rate of strain of velocities v at
// positions x.
struct Motion {
  double* x;
  double* v;
  double tolerance;  // excess that is not corrected [1] or [1/s]
};

// Corrects the elements of the listed batches, one batch after another. Bit l of corrected[batch]:
// lane l was corrected.
void sweep(const Tables& tables, const Motion& motion, const Index* batches, Index n,
           std::uint8_t* corrected);

// Computes the corrections (batches x 9 x 8) of all three corners without applying them.
void corrections(const Tables& tables, const Motion& motion, const Index* batches, Index n,
                 std::uint8_t* corrected, double* out);

// Corrects one element; true if it violated its limits. Needs tables.rows.
bool correct_one(const Tables& tables, const Motion& motion, Index slot);

// Where check() writes what it finds.
struct Violations {
  double* excess;   // (batches) largest excess among a batch's elements, 0: all within bounds
  double* strains;  // (batches x 3 x 8) strains, or rates of strain, of batches with an excess
};

// Checks n batches: those from entry `first` of `batches` on, or, if `batches` is null, those from
// number `first` on.
void check(const Tables& tables, const Motion& motion, const Index* batches, Index first, Index n,
           Violations out);

}  // namespace loomstone::limit
