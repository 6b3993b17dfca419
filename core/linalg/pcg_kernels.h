// Vector kernels of conjugate gradients in single and double precision, for a slice of eight rows
// (sliced_ellpack.h) at once. Directions p and solutions x have four numbers per row; the fourth is
// zero. Residuals r, z = D^-1 r and products q have the shape (slices x 3 x 8). Inverse diagonal
// blocks D^-1 have the shape (slices x 6 x 8), with the entries 00 01 02 11 12 22. Dot products are
// accumulated in double precision.
#pragma once

#include "core/base/types.h"

namespace loomstone::pcg {

// Inverts eight symmetric 3x3 blocks in place, stored with the shape (6 x 8). Bit l of the result
// is set if block l is not positive definite.
unsigned invert(double* blocks);

// Adds the rows of slices [first, last) of v to the sums of their slots. Slots are those of
// AggregationMultigrid here and below. Lane l of slice s has slot slots[8 s + l]. `sums` has four
// numbers per slot.
void add_up(Index first, Index last, const Index* slots, const float* v, float* sums);
void add_up(Index first, Index last, const Index* slots, const double* v, double* sums);

// SliceRows, DirectionFactors and PreconditionedResidual are the arguments of update_direction(),
// which computes x += length p, then p = z + correction + beta p, on the rows of slices
// [first, last).
struct SliceRows {
  Index first, last;
  const Index *rows, *slots;  // (all slices x 8)
  // Rows [begin, end) of this rank. x begins with row `begin`. The entry of an empty lane in `rows`
  // is at least `end`. Empty lanes use the row of x that follows these rows.
  Index begin, end;
};
template <class Scalar>
struct DirectionFactors {
  double length;
  Scalar beta;
};
template <class Scalar>
struct PreconditionedResidual {
  const Scalar* z;
  const float* correction;  // four numbers per slot; may be null
};
void update_direction(SliceRows on, DirectionFactors<float> factors,
                      PreconditionedResidual<float> residual, float* p, double* x);
void update_direction(SliceRows on, DirectionFactors<double> factors,
                      PreconditionedResidual<double> residual, double* p, double* x);

// Computes z = D^-1 r on slices [first, last). Returns r . z.
double precondition(Index first, Index last, const float* inverse, const float* r, float* z);
double precondition(Index first, Index last, const double* inverse, const double* r, double* z);
// Returns r . D^-1 r on slices [first, last).
double preconditioned_square(Index first, Index last, const float* inverse, const double* r);

// The vectors that take_step() updates. take_step() computes r -= alpha q and z = D^-1 r, and
// returns r . z.
template <class Scalar>
struct Residuals {
  Scalar *r, *z;
};
double take_step(Index first, Index last, float alpha, const float* q, const float* inverse,
                 Residuals<float> out);
double take_step(Index first, Index last, double alpha, const double* q, const double* inverse,
                 Residuals<double> out);

// Computes x += length p on n rows.
void move(Index n, double length, const float* p, double* x);
void move(Index n, double length, const double* p, double* x);

}  // namespace loomstone::pcg
