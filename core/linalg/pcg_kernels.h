// The vector arithmetic of conjugate gradients, in single and in double precision, eight rows at
// once. Directions and solutions have four numbers a row, the fourth zero; residuals r, z = P^-1 r
// and products q (slices x 3 x 8); inverse diagonal blocks (slices x 6 x 8): 00 01 02 11 12 22.
// Scalar products are in double precision.
#pragma once

#include "core/base/types.h"

namespace loomstone::pcg {

// Inverse of symmetric 3x3 blocks (6 x 8, in place); bit l of the result: block l is not positive
// definite.
unsigned invert(double* blocks);

// sums[slots[i]] += r of the row at place i (slots: slices x 8; sums: four numbers a slot).
void add_up(Index first, Index last, const Index* slots, const float* r, float* sums);
void add_up(Index first, Index last, const Index* slots, const double* r, float* sums);

// x += length p, then p = z + beta p, on the rows of the slices (rows: slices x 8); where
// `correction` (four numbers a slot) is given, p = z + correction[slots[i]] + beta p.
struct Places {
  const Index *rows, *slots;
};
void update_direction(Index first, Index last, const Places& places, double length, float beta,
                      const float* z, const float* correction, float* p, double* x);
void update_direction(Index first, Index last, const Places& places, double length, double beta,
                      const double* z, const float* correction, double* p, double* x);

// z = P^-1 r; returns r . z
double precondition(Index first, Index last, const float* inverse, const float* r, float* z);
double precondition(Index first, Index last, const double* inverse, const double* r, double* z);
// r . P^-1 r
double preconditioned_square(Index first, Index last, const float* inverse, const double* r);

// r -= alpha q, z = P^-1 r; returns r . z
double take_step(Index first, Index last, float alpha, const float* q, const float* inverse,
                 float* r, float* z);
double take_step(Index first, Index last, double alpha, const double* q, const double* inverse,
                 double* r, double* z);

// x += length p on rows [begin, end)
void move(Index begin, Index end, double length, const float* p, double* x);
void move(Index begin, Index end, double length, const double* p, double* x);

}  // namespace loomstone::pcg
