// Evaluates a local expansion at one point. Each SIMD lane handles a different power of x. Nested
// sums over powers of z, y and x yield the polynomial's first and second derivatives along all
// axes.
#include "core/magnetics/fast_sums/taylor_expansion.h"
#include "core/magnetics/sources/lane_math.h"

namespace loomstone {

namespace {

constexpr int most_powers = TaylorExpansion::highest_order + 1;
constexpr int below = 2;  // number of zeros before x^0, in place of the powers -2 and -1

// Writes x^k / k! to out[k + below] for k < n, and zeros to the first `below` entries.
LOOMSTONE_INLINE void powers_of(double x, int n, double* out) {
  out[0] = out[1] = 0.0;
  out[below] = 1.0;
  for (int k = 1; k < n; ++k) out[below + k] = out[below + k - 1] * (x / k);
}

// Masks that keep the first n of eight lanes.
struct LaneMasks {
  long long rows[n_lanes + 1][n_lanes] = {};
  constexpr LaneMasks() {
    for (int n = 0; n <= n_lanes; ++n)
      for (int lane = 0; lane < n; ++lane) rows[n][lane] = -1;
  }
};
constexpr LaneMasks masks;

template <class Lanes>
LOOMSTONE_INLINE Lanes first_of(const double* values, int n) {
  const double* kept = reinterpret_cast<const double*>(masks.rows[n < n_lanes ? n : n_lanes]);
  return lanes_of_bits<Lanes>(lanes_bits(lanes_load<Lanes>(values)) &
                              lanes_bits(lanes_load<Lanes>(kept)));
}

// Evaluates the expansion at the point `at` relative to its centre. `rows` contains the
// coefficients, ordered by powers of x (fastest), z and y (slowest).
template <class Lanes>
LOOMSTONE_INLINE void point_kernel(const double* rows, int order, const double* at, double* field,
                                   double* gradient) {
  double x[below + 2 * n_lanes] = {}, y[below + most_powers], z[below + most_powers];
  powers_of(at[0], order + 1, x);
  powers_of(at[1], order + 1, y);
  powers_of(at[2], order + 1, z);
  for (int c = 0; c < 3; ++c) field[c] = 0.0;
  for (int c = 0; c < 6; ++c) gradient[c] = 0.0;
  for (int first = 0; first <= order; first += n_lanes) {  // power of x in the first lane
    Lanes none = Lanes{}, s = none, sy = none, sz = none, syy = none, syz = none, szz = none;
    const double* row = rows;
    for (int b = 0; b <= order; ++b) {
      Lanes t = none, tz = none, tzz = none;
      for (int c = 0; c <= order - b; ++c) {
        const int length = order + 1 - b - c;
        if (length > first) {
          const Lanes v = first_of<Lanes>(row + first, length - first);
          t += z[below + c] * v;
          tz += z[below + c - 1] * v;
          tzz += z[below + c - 2] * v;
        }
        row += length;
      }
      s += y[below + b] * t;
      sy += y[below + b - 1] * t;
      syy += y[below + b - 2] * t;
      sz += y[below + b] * tz;
      syz += y[below + b - 1] * tz;
      szz += y[below + b] * tzz;
    }
    const Lanes w = lanes_load<Lanes>(x + below + first),
                wx = lanes_load<Lanes>(x + below + first - 1), wxx = lanes_load<Lanes>(x + first);
    field[0] -= lanes_sum(wx * s);
    field[1] -= lanes_sum(w * sy);
    field[2] -= lanes_sum(w * sz);
    gradient[0] -= lanes_sum(wxx * s);
    gradient[1] -= lanes_sum(wx * sy);
    gradient[2] -= lanes_sum(wx * sz);
    gradient[3] -= lanes_sum(w * syy);
    gradient[4] -= lanes_sum(w * syz);
    gradient[5] -= lanes_sum(w * szz);
  }
}

}  // namespace

void TaylorExpansion::pack(const double* local, double* rows) const {
  for (const int place : tables_.rows) *rows++ = local[place];
}

void TaylorExpansion::evaluate_at(const double* rows, const Vec3& centre, const double* point,
                                  double* field, double* gradient) const {
  const double at[3] = {point[0] - centre[0], point[1] - centre[1], point[2] - centre[2]};
  LOOMSTONE_WIDEST(point_kernel)(rows, tables_.order, at, field, gradient);
}

}  // namespace loomstone
