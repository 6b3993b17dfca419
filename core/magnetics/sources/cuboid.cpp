// Closed-form field of a cuboid. The logarithms of the four edges along an axis are merged into
// one. The solid angle of a face is computed from its corners.
#include <cmath>
#include <string>

#include "core/magnetics/sources/constants.h"
#include "core/magnetics/sources/lane_math.h"
#include "core/magnetics/sources/polyhedron.h"

namespace loomstone {

namespace {

// Distances in units of half the diagonal. A point closer than on_face to the plane of a face is
// moved to this distance; see across(). Distances from edges and corners count as at least on_edge,
// which prevents divisions by zero.
constexpr double on_face = 1e-12, on_edge = 1e-15;

// Computes the signed distances x + a and x - a from the two faces perpendicular to an axis, in
// units of half the diagonal. A point closer than on_face to the plane of a face is moved to this
// distance on the outer side of the face.
template <class Lanes>
LOOMSTONE_INLINE void across(const Lanes& x, double a, double scale, Lanes* out) {
  out[0] = (x + a) * scale;
  out[1] = (x - a) * scale;
  out[0] = lanes_select(lanes_abs(out[0]) < on_face, lanes_all<Lanes>(-on_face), out[0]);
  out[1] = lanes_select(lanes_abs(out[1]) < on_face, lanes_all<Lanes>(on_face), out[1]);
}

// Returns the signed sum of the logarithms L (see polyhedron.h) of the four edges along axis w. The
// sign of each term is the product of the signs of the edge's coordinates along the other two axes.
template <class Lanes>
LOOMSTONE_INLINE Lanes edges_along(const Lanes* u, const Lanes* v, const Lanes* w, double length,
                                   const Lanes r[2][2][2]) {
  const MaskOf<Lanes> outside = w[0] * w[1] > 0.0;
  const Lanes twice_beyond =
      lanes_select(outside, 2.0 * lanes_min(lanes_abs(w[0]), lanes_abs(w[1])), Lanes{});
  Lanes above = lanes_all<Lanes>(1.0), below = above;
  for (int i = 0; i < 2; ++i) {
    for (int k = 0; k < 2; ++k) {
      const Lanes square =
          lanes_max(u[i] * u[i] + v[k] * v[k], lanes_all<Lanes>(on_edge * on_edge));
      const Lanes e0 = r[i][k][0] + lanes_abs(w[0]), e1 = r[i][k][1] + lanes_abs(w[1]);
      const Lanes sum = r[i][k][0] + r[i][k][1] + length;
      // `defect` is e0 e1 (r0 + r1 - length), where r0 + r1 - length is computed without
      // cancellation as square (1/e0 + 1/e1) + twice_beyond.
      const Lanes both = e0 * e1;
      const Lanes defect = square * (e0 + e1) + twice_beyond * both;
      if (i == k) {
        above *= sum * both;
        below *= defect;
      } else {
        above *= defect;
        below *= sum * both;
      }
    }
  }
  return lanes_log(above / below);
}

// Returns the difference of the solid angles subtended by the two faces perpendicular to axis u:
// that of the face at larger u minus that of the face at smaller u. A solid angle is positive if
// the point is at larger u than the face.
template <class Lanes>
LOOMSTONE_INLINE Lanes faces_across(const Lanes* u, const Lanes* v, const Lanes* w,
                                    const Lanes r[2][2][2]) {
  Lanes sum{};
  for (int i = 0; i < 2; ++i) {
    // A corner contributes the angle of the vector (|u| r, v w sign u). This angle lies in
    // [-pi/2, pi/2]. The difference between the angles of two corners is computed as the angle of a
    // product of complex numbers.
    const Lanes size = lanes_abs(u[i]);
    Lanes face{};
    for (int k = 0; k < 2; ++k) {
      const Lanes v_signed = lanes_with_sign(v[k], v[k] * u[i]);
      const Lanes x0 = size * r[i][k][0], y0 = v_signed * w[0], x1 = size * r[i][k][1],
                  y1 = v_signed * w[1];
      const Lanes angle = lanes_atan2(y0 * x1 - y1 * x0, x0 * x1 + y0 * y1);
      face += k == 0 ? angle : -angle;
    }
    sum += i == 1 ? face : -face;
  }
  return sum;
}

// Cyclic permutation of the axes of r: out[k][l][i] = r[i][k][l].
template <class Lanes>
LOOMSTONE_INLINE void turn(const Lanes r[2][2][2], Lanes out[2][2][2]) {
  for (int i = 0; i < 2; ++i)
    for (int k = 0; k < 2; ++k)
      for (int l = 0; l < 2; ++l) out[k][l][i] = r[i][k][l];
}

struct CuboidTerms {
  // Half edge lengths [m], J [T], and the term that is added inside the cuboid [T]: J for B, 0 for
  // mu0 H.
  const double *half, *j, *inside_j;
  double scale;  // inverse of half the diagonal [1/m]
};

template <class Lanes>
LOOMSTONE_INLINE void field_kernel(CuboidTerms cuboid, const double* points, Index n, double* out) {
  const auto [half, j, inside_j, scale] = cuboid;
  constexpr double share = 1.0 / (4.0 * pi);
  for (Index i = 0; i < n; i += n_lanes) {
    Lanes x[2], y[2], z[2], r[2][2][2], ryzx[2][2][2], rzxy[2][2][2];
    across(lanes_load<Lanes>(points + i), half[0], scale, x);
    across(lanes_load<Lanes>(points + n + i), half[1], scale, y);
    across(lanes_load<Lanes>(points + 2 * n + i), half[2], scale, z);
    for (int a = 0; a < 2; ++a)
      for (int b = 0; b < 2; ++b)
        for (int c = 0; c < 2; ++c)
          r[a][b][c] = lanes_sqrt(lanes_max(x[a] * x[a] + y[b] * y[b] + z[c] * z[c],
                                            lanes_all<Lanes>(on_edge * on_edge)));
    turn(r, ryzx);
    turn(ryzx, rzxy);
    const Lanes xx = faces_across(x, y, z, r), yy = faces_across(y, z, x, ryzx),
                zz = faces_across(z, x, y, rzxy);
    const Lanes xy = edges_along(x, y, z, 2.0 * half[2] * scale, r),
                yz = edges_along(y, z, x, 2.0 * half[0] * scale, ryzx),
                xz = edges_along(z, x, y, 2.0 * half[1] * scale, rzxy);
    const MaskOf<Lanes> inside = (x[0] * x[1] < 0.0) & (y[0] * y[1] < 0.0) & (z[0] * z[1] < 0.0);
    const Lanes zero{};
    lanes_store(out + i, share * (j[0] * xx + j[1] * xy + j[2] * xz) +
                             lanes_select(inside, lanes_all<Lanes>(inside_j[0]), zero));
    lanes_store(out + n + i, share * (j[0] * xy + j[1] * yy + j[2] * yz) +
                                 lanes_select(inside, lanes_all<Lanes>(inside_j[1]), zero));
    lanes_store(out + 2 * n + i, share * (j[0] * xz + j[1] * yz + j[2] * zz) +
                                     lanes_select(inside, lanes_all<Lanes>(inside_j[2]), zero));
  }
}

}  // namespace

void Cuboid::near_field(const double* points, Index n, Quantity quantity, double* field) const {
  const Vec3 half = 0.5 * size_;
  const Vec3 inside = quantity == Quantity::flux_density ? polarization() : Vec3(Vec3::Zero());
  const CuboidTerms cuboid{half.data(), polarization().data(), inside.data(), 1.0 / radius()};
  LOOMSTONE_WIDEST(field_kernel)(cuboid, points, n, field);
}

}  // namespace loomstone
