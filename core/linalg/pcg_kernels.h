// Vector arithmetic of conjugate gradients in single and double precision, eight rows at once.
// Directions and solutions have four numbers a row, the fourth zero; residuals r, z = P^-1 r and
// products q (slices x 3 x 8); inverse diagonal blocks (slices x 6 x 8): 00 01 02 11 12 22. Scalar
// products are in double precision.
#pragma once

#include "core/base/types.h"

namespace loomstone::pcg {

// Inverse of symmetric 3x3 blocks (6 x 8, in place); bit l of the result: block l is not positive
// definite.
unsigned invert(double* blocks);

// sums[slots[i]] += r of the row at place i (slots: slices x 8; sums: four numbers a slot).
void add_up(Index first, Index last, const Index* slots, const float* r, float* sums);
void add_up(Index first, Index last, const Index* slots, const double* r, float* sums);

// x += length p, then p = z + correction + beta p, on the rows of the slices [first, last).
struct SliceRows {
  Index first, last;
  const Index *rows, *slots;  // (all slices x 8)
};
template <class Scalar>
struct DirectionFactors {
  double length;
  Scalar beta;
};
template <class Scalar>
struct PreconditionedResidual {
  const Scalar* z;
  const float* correction;  // four numbers a slot; null: none
};
void update_direction(SliceRows on, DirectionFactors<float> factors,
                      PreconditionedResidual<float> residual, float* p, double* x);
void update_direction(SliceRows on, DirectionFactors<double> factors,
                      PreconditionedResidual<double> residual, double* p, double* x);

// z = P^-1 r; returns r . z
double precondition(Index first, Index last, const float* inverse, const float* r, float* z);
double precondition(Index first, Index last, const double* inverse, const double* r, double* z);
// r . P^-1 r
double preconditioned_square(Index first, Index last, const float* inverse, const double* r);

// r -= alpha q, z = P^-1 r; returns r . z
template <class Scalar>
struct Residuals {
  Scalar *r, *z;
};
double take_step(Index first, Index last, float alpha, const float* q, const float* inverse,
                 Residuals<float> out);
double take_step(Index first, Index last, double alpha, const double* q, const double* inverse,
                 Residuals<double> out);

// x += length p on rows [begin, end)
void move(Index begin, Index end, double length, const float* p, double* x);
void move(Index begin, Index end, double length, const double* p, double* x);

}  // namespace loomstone::pcg
