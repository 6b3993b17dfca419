// The vector arithmetic of conjugate gradients, in single and in double precision. Vectors have four numbers a row, the
// fourth zero; inverse diagonal blocks have three columns of four. Sums are in double precision.
#pragma once

#include "core/base/types.h"

namespace loomstone::pcg {

// p = z + beta p
void update_direction(Index begin, Index end, float beta, const float* z, float* p);
void update_direction(Index begin, Index end, double beta, const double* z, double* p);

double dot(Index begin, Index end, const float* a, const float* b);
double dot(Index begin, Index end, const double* a, const double* b);

// z = P^-1 r; returns r . z
double precondition(Index begin, Index end, const float* inverse, const float* r, float* z);
double precondition(Index begin, Index end, const double* inverse, const double* r, double* z);

// x += scale alpha p, r -= alpha q, z = P^-1 r; returns r . z
double take_step(Index begin, Index end, float alpha, double scale, const float* p, const float* q, const float* inverse,
                 double* x, float* r, float* z);
double take_step(Index begin, Index end, double alpha, double scale, const double* p, const double* q,
                 const double* inverse, double* x, double* r, double* z);

}  // namespace loomstone::pcg
