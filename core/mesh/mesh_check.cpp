// Validates triangle meshes. Two triangle fans that share only one vertex ("bow tie") are accepted,
// because cloth may be connected at a point.
#include "core/mesh/mesh_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <string>
#include <vector>

#include "core/base/message.h"

namespace loomstone {
namespace {

// Lower bounds on the height of a triangle above its longest edge, as fractions of the length of
// this edge and of the largest absolute coordinate of all vertices (or of all uv). A triangle
// counts as having zero area unless its height exceeds both bounds. The first value is heuristic.
// The second exceeds the rounding errors of collinear points.
constexpr double smallest_height_of_edge = 1e-9;
constexpr double smallest_height_of_coordinate = 16.0 * 2.2e-16;

std::string corners(const Triangles& triangles, Index t) {
  return formatted("({}, {}, {})", triangles(t, 0), triangles(t, 1), triangles(t, 2));
}

// An edge of a triangle: its vertices in ascending order, and its direction in the triangle.
struct Side {
  Index low, high;
  Index triangle;
  bool ascending;  // true: the side runs from low to high

  bool same_edge(const Side& other) const { return low == other.low && high == other.high; }
};

std::vector<Side> sorted_sides(const Triangles& triangles) {
  std::vector<Side> sides;
  sides.reserve(static_cast<std::size_t>(triangles.size()));
  for (Index t = 0; t < triangles.rows(); ++t) {
    for (int c = 0; c < 3; ++c) {
      const Index a = triangles(t, c), b = triangles(t, (c + 1) % 3);
      sides.push_back({std::min(a, b), std::max(a, b), t, a < b});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    if (a.low != b.low) return a.low < b.low;
    if (a.high != b.high) return a.high < b.high;
    return a.triangle < b.triangle;
  });
  return sides;
}

template <class Array>
void check_finite(const Array& points, const char* what) {
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    if (!points.row(i).allFinite()) {
      fail<InvalidInput>(
          "{} {} must have finite coordinates, got NaN or infinity; correct or remove it", what, i);
    }
  }
}

void check_indices(const Triangles& triangles, Eigen::Index n_points, const char* what) {
  for (Index t = 0; t < triangles.rows(); ++t) {
    for (int c = 0; c < 3; ++c) {
      if (triangles(t, c) < 0 || triangles(t, c) >= n_points) {
        fail<InvalidInput>(
            "triangle {} must refer to {} 0 to {}, got {}; count from 0 and check that the arrays "
            "belong together",
            t, what, n_points - 1, triangles(t, c));
      }
    }
  }
}

template <class Array>
bool flat_triangle(const Array& points, const Triangles& triangles, Index t,
                   double largest_coordinate) {
  Vec3 corner[3] = {Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  for (int c = 0; c < 3; ++c)
    corner[c].head(points.cols()) = points.row(triangles(t, c)).transpose();
  const Vec3 e1 = corner[1] - corner[0], e2 = corner[2] - corner[0];
  const double longest =
      std::sqrt(std::max({e1.squaredNorm(), e2.squaredNorm(), (e2 - e1).squaredNorm()}));
  if (longest == 0.0) return true;
  const double height = (e1 / longest).cross(e2).norm();
  return height <= std::max(smallest_height_of_edge * longest,
                            smallest_height_of_coordinate * largest_coordinate);
}

void check_duplicates(const Triangles& triangles) {
  std::vector<std::array<Index, 4>> sorted(static_cast<std::size_t>(triangles.rows()));
  for (Index t = 0; t < triangles.rows(); ++t) {
    std::array<Index, 4>& row = sorted[static_cast<std::size_t>(t)];
    row = {triangles(t, 0), triangles(t, 1), triangles(t, 2), t};
    std::sort(row.begin(), row.begin() + 3);
  }
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    if (std::equal(sorted[i].begin(), sorted[i].begin() + 3, sorted[i - 1].begin())) {
      fail<InvalidInput>(
          "triangles must differ, but triangle {} has the same vertices {} as triangle {}; remove "
          "one of them",
          sorted[i][3], corners(triangles, sorted[i][3]), sorted[i - 1][3]);
    }
  }
}

void check_manifold(const std::vector<Side>& sides) {
  for (std::size_t i = 2; i < sides.size(); ++i) {
    if (sides[i].same_edge(sides[i - 2])) {
      fail<InvalidInput>(
          "edge ({}, {}) must have one or two triangles, but triangles {}, {} and {} meet there "
          "(non-manifold); duplicate its vertices to split the surface, or remove a triangle",
          sides[i].low, sides[i].high, sides[i - 2].triangle, sides[i - 1].triangle,
          sides[i].triangle);
    }
  }
}

// Throws InvalidInput if neighbouring triangles have opposite winding. The message names the
// triangle with the most conflicts, because a single inverted triangle conflicts with all its
// neighbours.
void check_winding(const Triangles& triangles, const std::vector<Side>& sides) {
  std::vector<int> conflicts(static_cast<std::size_t>(triangles.rows()), 0);
  std::vector<std::size_t> bad;
  for (std::size_t i = 1; i < sides.size(); ++i) {
    if (!sides[i].same_edge(sides[i - 1]) || sides[i].ascending != sides[i - 1].ascending) continue;
    bad.push_back(i);
    ++conflicts[static_cast<std::size_t>(sides[i].triangle)];
    ++conflicts[static_cast<std::size_t>(sides[i - 1].triangle)];
  }
  if (bad.empty()) return;
  const Index worst =
      static_cast<Index>(std::max_element(conflicts.begin(), conflicts.end()) - conflicts.begin());
  for (const std::size_t i : bad) {
    if (sides[i].triangle != worst && sides[i - 1].triangle != worst) continue;
    const Index other = sides[i].triangle == worst ? sides[i - 1].triangle : sides[i].triangle;
    fail<InvalidInput>(
        "triangle {} must have the same winding as its neighbours, but {} is wound opposite to "
        "triangle {}, with which it shares edge ({}, {}); swap two of its vertices",
        worst, corners(triangles, worst), other, sides[i].low, sides[i].high);
  }
}

Index root_of(std::vector<Index>& parent, Index i) {
  while (parent[static_cast<std::size_t>(i)] != i) {
    Index& up = parent[static_cast<std::size_t>(i)];
    up = parent[static_cast<std::size_t>(up)];
    i = up;
  }
  return i;
}

// Returns the uv of a triangle at one of its vertices.
Vec2 uv_at(const Triangles& triangles, const Points2& uv, const Triangles& uv_triangles, Index t,
           Index vertex) {
  int c = 0;
  while (triangles(t, c) != vertex) ++c;
  return uv.row(uv_triangles(t, c)).transpose();
}

// Returns the panel of each triangle, identified by the smallest triangle index in the panel.
// Values of uv are compared instead of their indices, because many files repeat values.
std::vector<Index> panels(const Triangles& triangles, const Points2& uv,
                          const Triangles& uv_triangles) {
  std::vector<Index> parent(static_cast<std::size_t>(triangles.rows()));
  std::iota(parent.begin(), parent.end(), 0);
  const std::vector<Side> sides = sorted_sides(triangles);
  for (std::size_t i = 1; i < sides.size(); ++i) {
    if (!sides[i].same_edge(sides[i - 1])) continue;
    const auto agree = [&](Index vertex) {
      return uv_at(triangles, uv, uv_triangles, sides[i].triangle, vertex) ==
             uv_at(triangles, uv, uv_triangles, sides[i - 1].triangle, vertex);
    };
    if (!agree(sides[i].low) || !agree(sides[i].high)) continue;
    const Index a = root_of(parent, sides[i].triangle), b = root_of(parent, sides[i - 1].triangle);
    parent[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
  }
  for (Index t = 0; t < triangles.rows(); ++t)
    parent[static_cast<std::size_t>(t)] = root_of(parent, t);
  return parent;
}

double signed_area(const Points2& uv, const Triangles& uv_triangles, Index t) {
  const Vec2 a = uv.row(uv_triangles(t, 0)), b = uv.row(uv_triangles(t, 1)),
             c = uv.row(uv_triangles(t, 2));
  const Vec2 ab = b - a, ac = c - a;
  return 0.5 * (ab.x() * ac.y() - ab.y() * ac.x());
}

}  // namespace

void check_surface(const Points& vertices, const Triangles& triangles) {
  if (vertices.rows() == 0 || triangles.rows() == 0) {
    fail<InvalidInput>(
        "a mesh must have vertices and triangles, got {} vertices and {} triangles (empty mesh); "
        "check its source",
        vertices.rows(), triangles.rows());
  }
  check_finite(vertices, "vertex");
  check_indices(triangles, vertices.rows(), "vertices");
  for (Index t = 0; t < triangles.rows(); ++t) {
    if (triangles(t, 0) == triangles(t, 1) || triangles(t, 1) == triangles(t, 2) ||
        triangles(t, 2) == triangles(t, 0)) {
      fail<InvalidInput>(
          "triangle {} must have three different vertices, got {} (zero area); remove it", t,
          corners(triangles, t));
    }
  }
  const double largest = vertices.cwiseAbs().maxCoeff();
  for (Index t = 0; t < triangles.rows(); ++t) {
    if (flat_triangle(vertices, triangles, t, largest)) {
      fail<InvalidInput>("triangle {} has zero area; remove it or merge its vertices {}", t,
                         corners(triangles, t));
    }
  }
  check_duplicates(triangles);
  const std::vector<Side> sides = sorted_sides(triangles);
  check_manifold(sides);
  check_winding(triangles, sides);
  std::vector<char> used(static_cast<std::size_t>(vertices.rows()), 0);
  for (Index t = 0; t < triangles.rows(); ++t) {
    for (int c = 0; c < 3; ++c) used[static_cast<std::size_t>(triangles(t, c))] = 1;
  }
  const auto isolated = std::find(used.begin(), used.end(), 0);
  if (isolated != used.end()) {
    fail<InvalidInput>(
        "vertex {} must belong to a triangle, but {} vertices are isolated; remove the vertices "
        "that no triangle uses",
        isolated - used.begin(), std::count(used.begin(), used.end(), 0));
  }
}

void check_rest_coordinates(const Triangles& triangles, const Points2& uv,
                            const Triangles& uv_triangles) {
  if (uv_triangles.rows() != triangles.rows()) {
    fail<InvalidInput>(
        "uv_triangles must have one row per triangle, got {} rows for {} triangles; give every "
        "triangle its uv",
        uv_triangles.rows(), triangles.rows());
  }
  check_finite(uv, "uv");
  check_indices(uv_triangles, uv.rows(), "uv");
  const double largest = uv.cwiseAbs().maxCoeff();
  for (Index t = 0; t < triangles.rows(); ++t) {
    if (flat_triangle(uv, uv_triangles, t, largest)) {
      fail<InvalidInput>(
          "triangle {} has zero rest area in uv (uv {}, vertices {}); give it a flat pattern or "
          "leave out the uv",
          t, corners(uv_triangles, t), corners(triangles, t));
    }
  }
  const std::vector<Index> panel = panels(triangles, uv, uv_triangles);
  // Signed area of each panel, stored at the index of the panel's first triangle.
  std::vector<double> total(panel.size(), 0.0);
  for (Index t = 0; t < triangles.rows(); ++t) {
    total[static_cast<std::size_t>(panel[static_cast<std::size_t>(t)])] +=
        signed_area(uv, uv_triangles, t);
  }
  for (Index t = 0; t < triangles.rows(); ++t) {
    const Index first = panel[static_cast<std::size_t>(t)];
    if (signed_area(uv, uv_triangles, t) * total[static_cast<std::size_t>(first)] < 0.0) {
      fail<InvalidInput>(
          "triangle {} must be oriented in uv like most of its panel, but its uv {} are inverted; "
          "unfold the pattern there",
          t, corners(uv_triangles, t));
    }
  }
}

}  // namespace loomstone
