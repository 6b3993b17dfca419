#include "core/linalg/pcg_kernels.h"

#include <cstddef>

#include "core/linalg/quad.h"

namespace loomstone::pcg {

namespace {

std::size_t at(Index row) { return 4 * static_cast<std::size_t>(row); }

template <class Scalar>
LOOMSTONE_INLINE void directions(Index begin, Index end, Scalar beta, const Scalar* z, Scalar* p) {
  for (std::size_t i = at(begin); i < at(end); ++i) p[i] = z[i] + beta * p[i];
}

// Eight partial sums, so that additions do not wait for one another; always added in the same order.
template <class Scalar>
LOOMSTONE_INLINE double product_sum(Index begin, Index end, const Scalar* a, const Scalar* b) {
  double sum[8] = {};
  std::size_t i = at(begin);
  for (; i + 8 <= at(end); i += 8)
    for (int l = 0; l < 8; ++l) sum[l] += static_cast<double>(a[i + l]) * static_cast<double>(b[i + l]);
  for (int l = 0; i + l < at(end); ++l) sum[l] += static_cast<double>(a[i + l]) * static_cast<double>(b[i + l]);
  return ((sum[0] + sum[1]) + (sum[2] + sum[3])) + ((sum[4] + sum[5]) + (sum[6] + sum[7]));
}

template <class Scalar>
LOOMSTONE_INLINE double preconditioned(Index begin, Index end, const Scalar* inverse, const Scalar* r, Scalar* z) {
  for (Index row = begin; row < end; ++row) {
    const Scalar* m = inverse + 12 * static_cast<std::size_t>(row);
    const auto residual = quad_load(r + at(row));
    quad_store(z + at(row), (quad_load(m) * residual[0] + quad_load(m + 4) * residual[1]) + quad_load(m + 8) * residual[2]);
  }
  return product_sum(begin, end, r, z);
}

template <class Scalar>
LOOMSTONE_INLINE double step(Index begin, Index end, Scalar alpha, double scale, const Scalar* p, const Scalar* q,
                             const Scalar* inverse, double* x, Scalar* r, Scalar* z) {
  const double length = scale * static_cast<double>(alpha);
  for (std::size_t i = at(begin); i < at(end); ++i) x[i] += length * static_cast<double>(p[i]);
  for (std::size_t i = at(begin); i < at(end); ++i) r[i] -= alpha * q[i];
  return preconditioned(begin, end, inverse, r, z);
}

}  // namespace

LOOMSTONE_CLONES
void update_direction(Index begin, Index end, float beta, const float* z, float* p) { directions(begin, end, beta, z, p); }
LOOMSTONE_CLONES
void update_direction(Index begin, Index end, double beta, const double* z, double* p) {
  directions(begin, end, beta, z, p);
}

LOOMSTONE_CLONES
double dot(Index begin, Index end, const float* a, const float* b) { return product_sum(begin, end, a, b); }
LOOMSTONE_CLONES
double dot(Index begin, Index end, const double* a, const double* b) { return product_sum(begin, end, a, b); }

LOOMSTONE_CLONES
double precondition(Index begin, Index end, const float* inverse, const float* r, float* z) {
  return preconditioned(begin, end, inverse, r, z);
}
LOOMSTONE_CLONES
double precondition(Index begin, Index end, const double* inverse, const double* r, double* z) {
  return preconditioned(begin, end, inverse, r, z);
}

LOOMSTONE_CLONES
double take_step(Index begin, Index end, float alpha, double scale, const float* p, const float* q, const float* inverse,
                 double* x, float* r, float* z) {
  return step(begin, end, alpha, scale, p, q, inverse, x, r, z);
}
LOOMSTONE_CLONES
double take_step(Index begin, Index end, double alpha, double scale, const double* p, const double* q,
                 const double* inverse, double* x, double* r, double* z) {
  return step(begin, end, alpha, scale, p, q, inverse, x, r, z);
}

}  // namespace loomstone::pcg
