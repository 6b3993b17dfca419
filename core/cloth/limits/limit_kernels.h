// The element arithmetic of strain limiting, on batches of eight triangles or on one.
#pragma once

#include <cstdint>

#include "core/cloth/limits/element_limit.h"

namespace loomstone::limit {

// Constant tables (but for what is held). Slot s is lane s % 8 of batch s / 8; of single elements
// likewise number s.
struct Tables {
  const Index* corners;       // (batches x 3 x 8) vertices
  const double* gradients;    // (batches x 4 x 8) of Element: all that looks read
  const double* numbers;      // (batches x 9 x 8) the others
  const std::uint8_t* moves;  // (slots) bit k: corner k may move; two_held; 0 on empty lanes
  const Index* bounds_of;     // (batches) row of bounds
  const Bounds* bounds;
  const double* rows;  // (slots x 13) Element again, for single elements; may be null
};
inline constexpr std::uint8_t two_held = 8;

// Strain of positions is limited where v is null, else the rate of strain of velocities v, at
// positions x.
struct Motion {
  double* x;
  double* v;
  double tolerance;  // [1] or [1/s]: what is let be
};

// Corrects the elements of the batches listed, one batch after another. corrected (batches): bit l:
// lane l was.
void sweep(const Tables& tables, const Motion& motion, const Index* batches, Index n,
           std::uint8_t* corrected);

// The corrections (batches x 9 x 8) of all three corners instead; nothing moves.
void corrections(const Tables& tables, const Motion& motion, const Index* batches, Index n,
                 std::uint8_t* corrected, double* out);

// One element; true where it was corrected. Needs tables.rows.
bool correct_one(const Tables& tables, const Motion& motion, Index slot);

// Looks at n batches from number `first` on, or from entry `first` of `batches` where given. excess
// (batches): the largest of a batch's elements, 0 where all are within their bounds; strains
// (batches x 3 x 8), or their rates, of batches with an excess.
void look(const Tables& tables, const Motion& motion, const Index* batches, Index first, Index n,
          double* excess, double* strains);

}  // namespace loomstone::limit
