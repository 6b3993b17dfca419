#include "core/collision/narrow_phase/float_continuous.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "core/base/lane_bits.h"

namespace loomstone {

namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();
constexpr int n_sides = 4;  // a triangle repeats its first side
// Lane 4 k + i of the packs contains coordinate k of the normal of side i. Four lanes are unused.
constexpr int n_packs = 2;

struct Polygon {
  double start[n_sides][3], end[n_sides][3];  // corners; each coordinate is one rounded difference
};

// Uses registers of four doubles even with AVX-512. With registers of eight, decisions took 1.4
// times as long (docs/experiments/collisions.md).
template <class Lanes>
using Registers = std::conditional_t<std::is_same_v<Lanes, Lanes512>, Lanes256, Lanes>;

// Bernstein coefficients of the side normals and of the volume, with error bounds. Let c_k be the
// corners of the polygon. The normal c_k x c_(k+1) of each side is quadratic in time. The volume
// that c_0, c_1 and c_2 span is cubic.
template <class Lanes>
struct Curves {
  Lanes side[3][n_packs];
  Lanes side_error[n_packs];
  double volume[4];
  double volume_error;
};

// Computes the coefficients in `curves` and their error bounds. Returns false if numbers are too
// large or too small for the error bounds to be valid.
template <int n_corners, class Lanes>
LOOMSTONE_INLINE bool prepare(const Polygon& p, Curves<Lanes>& curves) {
  alignas(64) double side[3][n_packs * n_lanes] = {}, error[n_packs * n_lanes];
  double size[n_corners];
  for (int i = 0; i < n_corners; ++i) {
    size[i] = 0.0;
    for (int k = 0; k < 3; ++k)
      size[i] = std::max({size[i], std::abs(p.start[i][k]), std::abs(p.end[i][k])});
  }
  for (int side_i = 0; side_i < n_sides; ++side_i) {
    const int i = side_i % n_corners, j = (i + 1) % n_corners;
    for (int k = 0; k < 3; ++k) {
      const int l = (k + 1) % 3, m = (k + 2) % 3, lane = 4 * k + side_i;
      side[0][lane] = p.start[i][l] * p.start[j][m] - p.start[i][m] * p.start[j][l];
      side[1][lane] = 0.5 * ((p.start[i][l] * p.end[j][m] - p.start[i][m] * p.end[j][l]) +
                             (p.end[i][l] * p.start[j][m] - p.end[i][m] * p.start[j][l]));
      side[2][lane] = p.end[i][l] * p.end[j][m] - p.end[i][m] * p.end[j][l];
      // In units of size[i] size[j], rounding of corners, products and sums contributes at most
      // 8 epsilon, and evaluation over subintervals of the step at most 6 epsilon.
      error[lane] = 16.0 * epsilon * size[i] * size[j];
    }
  }
  for (int lane = 12; lane < n_packs * n_lanes; ++lane) error[lane] = 0.0;
  for (int pack = 0; pack < n_packs; ++pack) {
    for (int i = 0; i < 3; ++i) curves.side[i][pack] = lanes_load<Lanes>(side[i] + n_lanes * pack);
    curves.side_error[pack] = lanes_load<Lanes>(error + n_lanes * pack);
  }
  // The volume is c_2 . (c_0 x c_1), where c_k are the corners of the polygon. Three corners
  // determine the plane of a parallelogram, too.
  double s[3][2];  // dot products of the coefficients of c_0 x c_1 with the start and end of c_2
  for (int i = 0; i < 3; ++i) {
    s[i][0] = side[i][0] * p.start[2][0] + side[i][4] * p.start[2][1] + side[i][8] * p.start[2][2];
    s[i][1] = side[i][0] * p.end[2][0] + side[i][4] * p.end[2][1] + side[i][8] * p.end[2][2];
  }
  curves.volume[0] = s[0][0];
  curves.volume[1] = (s[0][1] + 2.0 * s[1][0]) / 3.0;
  curves.volume[2] = (2.0 * s[1][1] + s[2][0]) / 3.0;
  curves.volume[3] = s[2][1];
  // In units of size[0] size[1] size[2], rounding of the coefficients contributes at most
  // 48 epsilon, and evaluation over subintervals at most 24 epsilon.
  curves.volume_error = 80.0 * epsilon * size[0] * size[1] * size[2];
  const double least = *std::min_element(size, size + n_corners),
               most = *std::max_element(size, size + n_corners);
  return least > 1e-130 && most < 1e140 && curves.volume_error > 1e-280 &&
         curves.volume_error < 1e280;
}

// Returns the Bernstein coefficients of the volume over [low, high].
LOOMSTONE_INLINE std::array<double, 4> volume_over(const double* c, double low, double high) {
  const double l = 1.0 - low, h = 1.0 - high;
  // The coefficients are values of the blossom b (polar form) of the volume. ll contains
  // b(low, low, 0) and b(low, low, 1), and hh contains b(high, high, 0) and b(high, high, 1).
  const double ll[2] = {l * l * c[0] + 2.0 * (l * low) * c[1] + low * low * c[2],
                        l * l * c[1] + 2.0 * (l * low) * c[2] + low * low * c[3]};
  const double hh[2] = {h * h * c[0] + 2.0 * (h * high) * c[1] + high * high * c[2],
                        h * h * c[1] + 2.0 * (h * high) * c[2] + high * high * c[3]};
  return {l * ll[0] + low * ll[1], h * ll[0] + high * ll[1], l * hh[0] + low * hh[1],
          h * hh[0] + high * hh[1]};
}

struct Sides {
  // Bit 4 k + i is set if coordinate k of the normal of side i has this sign in the whole interval.
  unsigned positive, negative;
};

template <class Lanes>
LOOMSTONE_INLINE Sides sides_over(const Curves<Lanes>& curves, double low, double high) {
  const double l = 1.0 - low, h = 1.0 - high;
  const double weight[3][3] = {{l * l, 2.0 * (l * low), low * low},
                               {l * h, l * high + low * h, low * high},
                               {h * h, 2.0 * (h * high), high * high}};
  Sides sides = {0, 0};
  for (int pack = 0; pack < n_packs; ++pack) {
    MaskOf<Lanes> positive, negative;
    for (int i = 0; i < 3; ++i) {
      const Lanes value = weight[i][0] * curves.side[0][pack] +
                          weight[i][1] * curves.side[1][pack] + weight[i][2] * curves.side[2][pack];
      const MaskOf<Lanes> above = value > curves.side_error[pack],
                          below = value < -curves.side_error[pack];
      positive = i == 0 ? above : positive & above;
      negative = i == 0 ? below : negative & below;
    }
    sides.positive |= lanes_bits(positive) << (n_lanes * pack);
    sides.negative |= lanes_bits(negative) << (n_lanes * pack);
  }
  return sides;
}

template <class Lanes, int n_corners>
LOOMSTONE_INLINE Decision decide(const Polygon& polygon) {
  // `begin` and `width` of a piece of [0, 1] are in units of the shortest length, 2^-40. A piece of
  // this length that is undecided stays open.
  constexpr std::uint64_t step = std::uint64_t{1} << 40;
  constexpr int most_pieces = 160;
  Curves<Lanes> curves;
  if (!prepare<n_corners>(polygon, curves)) return {Proof::Open, 0.0};
  const double error = curves.volume_error;
  std::uint64_t begin = 0, width = step;
  double low = 0.0, first_open = 2.0;
  for (int piece = 0; piece < most_pieces; ++piece) {
    low = static_cast<double>(begin) / step;
    const double high = static_cast<double>(begin + width) / step;
    const std::array<double, 4> v = volume_over(curves.volume, low, high);
    const bool above = v[0] > error && v[1] > error && v[2] > error && v[3] > error;
    const bool below = v[0] < -error && v[1] < -error && v[2] < -error && v[3] < -error;
    bool apart = above || below;
    if (!apart) {
      const Sides sides = sides_over(curves, low, high);
      bool inside = false;
      for (int k = 0; k < 3; ++k) {
        const unsigned positive = (sides.positive >> (4 * k)) & 15u,
                       negative = (sides.negative >> (4 * k)) & 15u;
        apart = apart || (positive && negative);
        inside = inside || positive == 15u || negative == 15u;
      }
      if (inside && ((v[0] > error && v[3] < -error) || (v[0] < -error && v[3] > error))) {
        // The features meet. Bisection sharpens the lower bound on the contact time.
        double end = high;
        for (int i = 0; i < 30 && end - low > 1e-9 * end; ++i) {
          const double middle = 0.5 * (low + end);
          const std::array<double, 4> w = volume_over(curves.volume, low, middle);
          const bool free = (w[0] > error && w[1] > error && w[2] > error && w[3] > error) ||
                            (w[0] < -error && w[1] < -error && w[2] < -error && w[3] < -error);
          (free ? low : end) = middle;
        }
        return {Proof::Meet, std::min(low, first_open)};
      }
    }
    if (!apart) {
      if (width > 1) {
        width /= 2;
        continue;
      }
      first_open = std::min(first_open, low);
    }
    begin += width;
    if (begin == step)
      return first_open < 1.0 ? Decision{Proof::Open, first_open} : Decision{Proof::Apart, 1.0};
    width = begin & (~begin + 1);  // the widest piece of the bisection that starts at `begin`
  }
  // The features are apart until the first open piece, or until `low` if no piece is open.
  return {Proof::Open, std::min(low, first_open)};
}

LOOMSTONE_INLINE void set(Polygon& polygon, int corner, const MovingPoints& q, int i, int j) {
  for (int k = 0; k < 3; ++k) {
    polygon.start[corner][k] = q[i][k] - q[j][k];
    polygon.end[corner][k] = q[4 + i][k] - q[4 + j][k];
  }
}

template <class Lanes>
LOOMSTONE_INLINE Decision vertex_face(const MovingPoints& points) {
  Polygon polygon;
  for (int j = 0; j < 3; ++j) set(polygon, j, points, 0, 1 + j);
  return decide<Registers<Lanes>, 3>(polygon);
}

template <class Lanes>
LOOMSTONE_INLINE Decision edge_edge(const MovingPoints& points) {
  Polygon polygon;
  set(polygon, 0, points, 0, 2);
  set(polygon, 1, points, 0, 3);
  set(polygon, 2, points, 1, 3);
  set(polygon, 3, points, 1, 2);
  return decide<Registers<Lanes>, 4>(polygon);
}

}  // namespace

Decision decide_vertex_face(const MovingPoints& points) {
  return LOOMSTONE_WIDEST(vertex_face)(points);
}

Decision decide_edge_edge(const MovingPoints& points) {
  return LOOMSTONE_WIDEST(edge_edge)(points);
}

}  // namespace loomstone
