// With G such that d^2/dx^2 d^2/dy^2 d^2/dz^2 G = 1/|R|, the force on cuboid 2 is
//   F_k = - 1/(4 pi mu0) sum_ij J1_i J2_j sum_corners s1 s2 T_ijk(R),   T_ijk = d_i d_j d_k G.
// J1 and J2 are the polarizations, and d_i is the derivative along axis i. R is the arm, the vector
// (x, y, z) from a corner of cuboid 1 to a corner of cuboid 2. s1 and s2 are the products of the
// signs of the coordinates of these two corners, each relative to the centre of its cuboid. For the
// moment of F_k about the centre of cuboid 2 with the lever along axis a, y_a T - U replaces T.
// Here y_a is the coordinate of the corner of cuboid 2 relative to this centre, and dU/dR_a = T.
// For a = j, the charged faces of cuboid 2 are normal to axis a, so the lever is constant on them,
// and U is omitted.
#include "core/magnetics/forces/cuboid_pair.h"

#include <algorithm>
#include <cmath>

#include "core/magnetics/sources/constants.h"
#include "core/magnetics/sources/lane_math.h"

namespace loomstone {

namespace {

// Arms (x, y, z) of eight pairs of corners: the components, the length r, and a logarithm and an
// angle for each axis. Those of axis x are arsinh(x / hypot(y, z)) and arctan(y z / (x r)).
template <class Lanes>
struct Arms {
  Lanes x[3], log[3], angle[3], r;
};

template <class Lanes>
LOOMSTONE_INLINE Arms<Lanes> arms_of(const Lanes* x) {
  Arms<Lanes> a;
  a.r = lanes_sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
  for (int i = 0; i < 3; ++i) {
    const Lanes &u = x[i], &v = x[(i + 1) % 3], &w = x[(i + 2) % 3];
    a.x[i] = u;
    a.log[i] = lanes_with_sign(lanes_log((a.r + lanes_abs(u)) / lanes_sqrt(v * v + w * w)), u);
    a.angle[i] = lanes_atan2(lanes_with_sign(v * w, v * w * u), lanes_abs(u) * a.r);
  }
  return a;
}

// Returns T_ijk (defined at the top of this file). Its closed form depends on how many of the
// indices are equal.
template <class Lanes>
LOOMSTONE_INLINE Lanes third(const Arms<Lanes>& a, int i, int j, int k) {
  if (i == j && j == k) {
    const int p = (i + 1) % 3, q = (i + 2) % 3;
    return a.x[i] * (a.r - a.x[p] * a.log[p] - a.x[q] * a.log[q]) - a.x[p] * a.x[q] * a.angle[i];
  }
  if (i != j && j != k && i != k)
    return a.x[1] * a.x[2] * a.log[0] + a.x[0] * a.x[2] * a.log[1] + a.x[0] * a.x[1] * a.log[2] -
           0.5 * (a.x[0] * a.x[0] * a.angle[0] + a.x[1] * a.x[1] * a.angle[1] +
                  a.x[2] * a.x[2] * a.angle[2]);
  const int twice = i == j || i == k ? i : j, once = i + j + k - 2 * twice,
            other = 3 - twice - once;
  const Lanes &x = a.x[once], &y = a.x[other], &z = a.x[twice];
  return 0.5 * (y * y - z * z) * a.log[once] + x * y * a.log[other] - y * z * a.angle[twice] -
         0.5 * a.r * x;
}

// Returns U (defined at the top of this file), the integral of T_ijk along `axis`. `axis` must
// differ from j and k.
template <class Lanes>
LOOMSTONE_INLINE Lanes integral(const Arms<Lanes>& a, int i, int j, int k, int axis) {
  if (i == j && j == k) {
    const int other = 3 - i - axis;
    const Lanes &x = a.x[axis], &y = a.x[other], &z = a.x[i];
    return 0.25 * z * (z * z - y * y - 2.0 * x * x) * a.log[axis] - x * y * z * a.log[other] +
           0.5 * y * (z * z - x * x) * a.angle[i] + 0.75 * x * z * a.r;
  }
  if (i != j && j != k && i != k) {  // `axis` is equal to i
    const Lanes &x = a.x[i], &y = a.x[j], &z = a.x[k];
    return x * y * z * a.log[i] + z * (0.5 * x * x - z * z / 6.0) * a.log[j] +
           y * (0.5 * x * x - y * y / 6.0) * a.log[k] -
           x * (x * x / 6.0 * a.angle[i] + 0.5 * (y * y * a.angle[j] + z * z * a.angle[k])) -
           y * z * a.r / 3.0;
  }
  const int twice = i == j || i == k ? i : j, once = i + j + k - 2 * twice,
            other = 3 - twice - once;
  const Lanes &x = a.x[once], &y = a.x[other], &z = a.x[twice];
  if (axis == once)
    return 0.5 * x * (y * y - z * z) * a.log[once] + 0.5 * y * (x * x - z * z) * a.log[other] -
           x * y * z * a.angle[twice] + a.r * (2.0 * z * z - y * y - x * x) / 6.0;
  return 0.5 * y * (y * y / 3.0 - z * z) * a.log[once] +
         x * (0.5 * y * y - 0.25 * z * z - x * x / 12.0) * a.log[other] +
         0.5 * z * (z * z / 3.0 - y * y) * a.angle[twice] - 5.0 / 12.0 * x * y * a.r;
}

template <class Lanes>
LOOMSTONE_INLINE double sum_in_order(const Lanes& a) {
  double sum = 0.0;
  for (int i = 0; i < n_lanes; ++i) sum += a[i];
  return sum;
}

// Pairs of each of the eight corners of cuboid 1 with one corner of cuboid 2. `sign` is -s1 s2, and
// y is the position of the corner of cuboid 2 relative to the centre of cuboid 2 [m].
template <class Lanes>
struct Corners {
  Arms<Lanes> arms;
  Lanes sign;
  double y[3];
};

struct Term {
  int i, j, k;
  double strength;  // J1_i J2_j
};

template <class Lanes>
LOOMSTONE_INLINE void add_term(const Corners<Lanes>& c, Term t, Lanes* forces, Lanes* moments) {
  const Lanes value = t.strength * c.sign * third(c.arms, t.i, t.j, t.k);
  forces[t.k] += value;
  for (int axis = 0; axis < 3; ++axis) {
    if (axis == t.k) continue;
    Lanes moment = c.y[axis] * value;
    if (axis != t.j) moment -= t.strength * c.sign * integral(c.arms, t.i, t.j, t.k, axis);
    moments[3 * axis + t.k] += moment;
  }
}

// Half edge lengths a of cuboid 1 and b of cuboid 2 [m], vector d from the centre of 1 to that of 2
// [m], and polarizations [T], all in the axes of cuboid 1.
struct CuboidPair {
  Vec3 a, b, d, j1, j2;
};

// Returns the pairs of all corners of cuboid 1 (one per lane) with the corner of cuboid 2 that has
// the index `corner`. Arms have components of at least `least` [m] in absolute value.
template <class Lanes>
LOOMSTONE_INLINE Corners<Lanes> corners_of(const CuboidPair& pair, int corner, double least) {
  const double *a = pair.a.data(), *b = pair.b.data(), *d = pair.d.data();
  double columns[3][n_lanes], signs[n_lanes];
  Corners<Lanes> result;
  for (int lane = 0; lane < n_lanes; ++lane) {
    signs[lane] = -1.0;
    for (int c = 0; c < 3; ++c) {
      const double s1 = lane >> c & 1 ? 1.0 : -1.0, s2 = corner >> c & 1 ? 1.0 : -1.0;
      const double arm = d[c] + s2 * b[c] - s1 * a[c];
      columns[c][lane] = std::abs(arm) > least ? arm : d[c] < 0.0 ? -least : least;
      result.y[c] = s2 * b[c];
      signs[lane] *= s1 * s2;
    }
  }
  const Lanes x[3] = {lanes_load<Lanes>(columns[0]), lanes_load<Lanes>(columns[1]),
                      lanes_load<Lanes>(columns[2])};
  result.sign = lanes_load<Lanes>(signs);
  result.arms = arms_of(x);
  return result;
}

// Adds to `force` (3) the sums of -s1 s2 J1_i J2_j T_ijk over i, j and all pairs of corners. Adds
// to `levers` the corresponding moments about the centre of cuboid 2 (3 x 3; row: axis of the
// lever, column: component of the force).
template <class Lanes>
LOOMSTONE_INLINE void corner_sums(const CuboidPair& pair, double* force, double* levers) {
  const double *a = pair.a.data(), *b = pair.b.data();
  // Coplanar faces of the two cuboids count as this far apart [m], in the direction from 1 to 2.
  const double least = 1e-15 * (a[0] + a[1] + a[2] + b[0] + b[1] + b[2]);
  Lanes forces[3], moments[9];
  for (Lanes& f : forces) f = Lanes{};
  for (Lanes& m : moments) m = Lanes{};
  for (int corner = 0; corner < 8; ++corner) {
    const Corners<Lanes> corners = corners_of<Lanes>(pair, corner, least);
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        const double strength = pair.j1[i] * pair.j2[j];
        if (strength == 0.0) continue;
        for (int k = 0; k < 3; ++k) add_term(corners, {i, j, k, strength}, forces, moments);
      }
    }
  }
  for (int k = 0; k < 3; ++k) force[k] += sum_in_order(forces[k]);
  for (int k = 0; k < 9; ++k) levers[k] += sum_in_order(moments[k]);
}

// Separates overlapping cuboids along the axis of least overlap until they touch, because the force
// between two faces jumps where they pass through each other.
void separate(CuboidPair& pair) {
  int axis;
  const Vec3 most = pair.a + pair.b;
  if ((most - pair.d.cwiseAbs()).minCoeff(&axis) > 0.0)
    pair.d[axis] = std::copysign(most[axis], pair.d[axis]);
}

}  // namespace

std::optional<Wrench> parallel_cuboid_wrench(const MagneticBody& on, const MagneticBody& by) {
  const std::optional<UniformCuboid> first = by.source->uniform_cuboid(),
                                     second = on.source->uniform_cuboid();
  if (!first || !second) return std::nullopt;
  const Mat3 to_world = rotation_matrix(by.pose.orientation);
  const Mat3 turn = to_world.transpose() * rotation_matrix(on.pose.orientation);
  const Mat3 whole = turn.array().round();
  if ((turn - whole).cwiseAbs().maxCoeff() > 1e-12) return std::nullopt;
  CuboidPair pair{0.5 * first->size, 0.5 * (whole.cwiseAbs() * second->size),
                  to_world.transpose() * (on.pose.position - by.pose.position), first->polarization,
                  whole * second->polarization};
  separate(pair);
  Vec3 force = Vec3::Zero();
  double levers[9] = {};
  LOOMSTONE_WIDEST(corner_sums)(pair, force.data(), levers);
  const double scale = 1.0 / (4.0 * pi * mu0);
  const Vec3 torque(levers[5] - levers[7], levers[6] - levers[2], levers[1] - levers[3]);
  // Rounding error of sums of 64 terms. Terms of the force grow with the square of the longest arm,
  // and terms of the torque with its cube.
  const double arm = (pair.a + pair.b + pair.d.cwiseAbs()).norm();
  const double strength = scale * first->polarization.norm() * second->polarization.norm();
  const double rounding =
      64.0 * 1e-16 * strength * arm * arm * std::max(1.0, arm / on.source->radius());
  return Wrench{to_world * (scale * force), to_world * (scale * torque), rounding};
}

}  // namespace loomstone
