#include "core/collision/narrow_phase/exact_predicates.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace loomstone {

namespace {

int sign(double x) { return (x > 0.0) - (x < 0.0); }

// A number as the exact sum of nonoverlapping doubles in ascending magnitude. The last part
// determines the sign.
template <int Capacity>
struct Expansion {
  std::array<double, Capacity> part;
  int n = 0;

  void push(double x) {
    if (x != 0.0) part[n++] = x;
  }
  int sign_of() const { return n == 0 ? 0 : sign(part[n - 1]); }
};

void two_sum(double a, double b, double& sum, double& error) {
  sum = a + b;
  const double b_part = sum - a, a_part = sum - b_part;
  error = (a - a_part) + (b - b_part);
}

void two_product(double a, double b, double& product, double& error) {
  product = a * b;
  error = std::fma(a, b, -product);
}

Expansion<2> difference(double a, double b) {
  double sum, error;
  two_sum(a, -b, sum, error);
  Expansion<2> e;
  e.push(error);
  e.push(sum);
  return e;
}

// Returns e + f. Adds the parts of f one by one (grow-expansion).
template <int N, int M>
Expansion<N + M> add(const Expansion<N>& e, const Expansion<M>& f) {
  Expansion<N + M> result;
  for (int i = 0; i < e.n; ++i) result.part[i] = e.part[i];
  result.n = e.n;
  for (int j = 0; j < f.n; ++j) {
    Expansion<N + M> grown;
    double carry = f.part[j];
    for (int i = 0; i < result.n; ++i) {
      double sum, error;
      two_sum(carry, result.part[i], sum, error);
      grown.push(error);
      carry = sum;
    }
    grown.push(carry);
    result = grown;
  }
  return result;
}

template <int N>
Expansion<2 * N> scale(const Expansion<N>& e, double factor) {
  Expansion<2 * N> result;
  for (int i = 0; i < e.n; ++i) {
    double product, error;
    two_product(e.part[i], factor, product, error);
    Expansion<2> term;
    term.push(error);
    term.push(product);
    const Expansion<2 * N + 2> sum = add(result, term);
    result.n = sum.n;
    std::copy(sum.part.begin(), sum.part.begin() + sum.n, result.part.begin());
  }
  return result;
}

template <int N>
Expansion<4 * N> multiply(const Expansion<N>& e, const Expansion<2>& f) {
  Expansion<4 * N> result;
  for (int j = 0; j < f.n; ++j) {
    const Expansion<6 * N> sum = add(result, scale(e, f.part[j]));
    result.n = sum.n;
    std::copy(sum.part.begin(), sum.part.begin() + sum.n, result.part.begin());
  }
  return result;
}

template <int N>
Expansion<N> negated(Expansion<N> e) {
  for (int i = 0; i < e.n; ++i) e.part[i] = -e.part[i];
  return e;
}

using Difference = Expansion<2>;

Expansion<16> minor_of(const Difference& a, const Difference& b, const Difference& c,
                       const Difference& d) {
  return add(multiply(a, d), negated(multiply(b, c)));
}

int exact_orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  Difference u[3], v[3], w[3];
  for (int k = 0; k < 3; ++k) {
    u[k] = difference(a[k], d[k]);
    v[k] = difference(b[k], d[k]);
    w[k] = difference(c[k], d[k]);
  }
  const auto x = multiply(minor_of(v[1], v[2], w[1], w[2]), u[0]);
  const auto y = multiply(minor_of(v[2], v[0], w[2], w[0]), u[1]);
  const auto z = multiply(minor_of(v[0], v[1], w[0], w[1]), u[2]);
  return add(add(x, y), z).sign_of();
}

// Returns whether the coplanar segments p q and r s intersect. Orientations are computed in the
// projection along coordinate `dropped`, in which the common plane must not become a line.
bool segments_meet_in_plane(const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& s,
                            int dropped) {
  const int a = orientation_in_plane(p, q, r, dropped), b = orientation_in_plane(p, q, s, dropped);
  const int c = orientation_in_plane(r, s, p, dropped), d = orientation_in_plane(r, s, q, dropped);
  if (a == 0 && b == 0 && c == 0 && d == 0) {
    for (int k = 0; k < 3; ++k)
      if (std::max(p[k], q[k]) < std::min(r[k], s[k]) ||
          std::max(r[k], s[k]) < std::min(p[k], q[k]))
        return false;
    return true;
  }
  return a * b <= 0 && c * d <= 0;
}

bool inside_in_plane(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c, int dropped) {
  const int x = orientation_in_plane(a, b, p, dropped), y = orientation_in_plane(b, c, p, dropped),
            z = orientation_in_plane(c, a, p, dropped);
  return (x >= 0 && y >= 0 && z >= 0) || (x <= 0 && y <= 0 && z <= 0);
}

// Returns whether segment p q intersects the triangle. side_p and side_q are the orientations of p
// and q relative to the plane of the triangle. They must not both be zero.
bool segment_meets_triangle(const Vec3& p, const Vec3& q, int side_p, int side_q,
                            const std::array<Vec3, 3>& triangle) {
  if (side_p * side_q > 0) return false;
  const auto& [a, b, c] = triangle;
  const int x = orientation(p, q, a, b), y = orientation(p, q, b, c), z = orientation(p, q, c, a);
  return (x >= 0 && y >= 0 && z >= 0) || (x <= 0 && y <= 0 && z <= 0);
}

// Returns the index (0 to 2) of a coordinate along which the triangle projects to a nonzero area,
// or -1 if the triangle is degenerate.
int dropped_coordinate(const Vec3& a, const Vec3& b, const Vec3& c) {
  for (int k = 0; k < 3; ++k)
    if (orientation_in_plane(a, b, c, k) != 0) return k;
  return -1;
}

}  // namespace

int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const double ux = a[0] - d[0], uy = a[1] - d[1], uz = a[2] - d[2];
  const double vx = b[0] - d[0], vy = b[1] - d[1], vz = b[2] - d[2];
  const double wx = c[0] - d[0], wy = c[1] - d[1], wz = c[2] - d[2];
  const double vw_x = vy * wz, wv_x = vz * wy, vw_y = vz * wx, wv_y = vx * wz, vw_z = vx * wy,
               wv_z = vy * wx;
  const double determinant = ux * (vw_x - wv_x) + uy * (vw_y - wv_y) + uz * (vw_z - wv_z);
  const double permanent = std::abs(ux) * (std::abs(vw_x) + std::abs(wv_x)) +
                           std::abs(uy) * (std::abs(vw_y) + std::abs(wv_y)) +
                           std::abs(uz) * (std::abs(vw_z) + std::abs(wv_z));
  // Shewchuk's error bound is (7 + 56 e) e times `permanent` with e = epsilon / 2. The bound used
  // here is larger.
  if (std::abs(determinant) > 8.0 * std::numeric_limits<double>::epsilon() * permanent)
    return sign(determinant);
  return exact_orientation(a, b, c, d);
}

int orientation_in_plane(const Vec3& a, const Vec3& b, const Vec3& c, int dropped) {
  const int i = (dropped + 1) % 3, j = (dropped + 2) % 3;
  const double left = (a[i] - c[i]) * (b[j] - c[j]), right = (a[j] - c[j]) * (b[i] - c[i]);
  const double determinant = left - right;
  if (std::abs(determinant) >
      4.0 * std::numeric_limits<double>::epsilon() * (std::abs(left) + std::abs(right)))
    return sign(determinant);
  return minor_of(difference(a[i], c[i]), difference(a[j], c[j]), difference(b[i], c[i]),
                  difference(b[j], c[j]))
      .sign_of();
}

bool triangles_meet(const Vec3& a0, const Vec3& a1, const Vec3& a2, const Vec3& b0, const Vec3& b1,
                    const Vec3& b2) {
  const std::array<Vec3, 3> a = {a0, a1, a2}, b = {b0, b1, b2};
  const int dropped_a = dropped_coordinate(a0, a1, a2), dropped_b = dropped_coordinate(b0, b1, b2);
  if (dropped_a < 0 && dropped_b < 0) return false;
  if (dropped_a < 0) return triangles_meet(b0, b1, b2, a0, a1, a2);
  std::array<int, 3> side_b, side_a{};
  for (int i = 0; i < 3; ++i) side_b[i] = orientation(a0, a1, a2, b[i]);
  if (side_b[0] == side_b[1] && side_b[1] == side_b[2]) {
    if (side_b[0] != 0) return false;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        if (segments_meet_in_plane(a[i], a[(i + 1) % 3], b[j], b[(j + 1) % 3], dropped_a))
          return true;
    return inside_in_plane(b0, a0, a1, a2, dropped_a) ||
           (dropped_b >= 0 && inside_in_plane(a0, b0, b1, b2, dropped_a));
  }
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    if (side_b[i] == 0 && side_b[j] == 0) {
      // This edge of b lies in the plane of a.
      if (inside_in_plane(b[i], a0, a1, a2, dropped_a)) return true;
      for (int k = 0; k < 3; ++k)
        if (segments_meet_in_plane(b[i], b[j], a[k], a[(k + 1) % 3], dropped_a)) return true;
    } else if (segment_meets_triangle(b[i], b[j], side_b[i], side_b[j], a)) {
      return true;
    }
  }
  if (dropped_b < 0) return false;
  for (int i = 0; i < 3; ++i) side_a[i] = orientation(b0, b1, b2, a[i]);
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    if ((side_a[i] != 0 || side_a[j] != 0) &&
        segment_meets_triangle(a[i], a[j], side_a[i], side_a[j], b))
      return true;
  }
  return false;
}

}  // namespace loomstone
