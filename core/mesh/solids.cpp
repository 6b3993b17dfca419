// Spheres from subdivided icosahedra, and boxes.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "core/mesh/generators.h"
#include "core/mesh/mesh_builder.h"

namespace loomstone {

TriangleMesh icosphere(double radius, int subdivisions) {
  require_positive(radius, "radius");
  require_between(subdivisions, 0, 8, "subdivisions");
  const double g = 0.5 * (1.0 + std::sqrt(5.0));
  MeshBuilder builder;
  for (const Vec3& v : {Vec3(-1, g, 0), Vec3(1, g, 0), Vec3(-1, -g, 0), Vec3(1, -g, 0),
                        Vec3(0, -1, g), Vec3(0, 1, g), Vec3(0, -1, -g), Vec3(0, 1, -g),
                        Vec3(g, 0, -1), Vec3(g, 0, 1), Vec3(-g, 0, -1), Vec3(-g, 0, 1)}) {
    builder.add(Vec3(v.normalized()));
  }
  builder.triangles = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                       {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                       {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                       {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  for (int level = 0; level < subdivisions; ++level) {
    std::map<std::pair<Index, Index>, Index> middles;
    const auto middle = [&](Index a, Index b) {
      const auto [entry, fresh] =
          middles.try_emplace(std::minmax(a, b), static_cast<Index>(builder.vertices.size()));
      if (fresh) {
        builder.add(Vec3((builder.vertices[static_cast<std::size_t>(a)] +
                          builder.vertices[static_cast<std::size_t>(b)])
                             .normalized()));
      }
      return entry->second;
    };
    const std::vector<std::array<Index, 3>> coarse = std::exchange(builder.triangles, {});
    for (const auto& [a, b, c] : coarse) {
      const Index ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      builder.add(a, ab, ca);
      builder.add(b, bc, ab);
      builder.add(c, ca, bc);
      builder.add(ab, bc, ca);
    }
  }
  for (Vec3& vertex : builder.vertices) vertex *= radius;
  return builder.mesh();
}

namespace {

// Adds a side of a box, with two triangles per cell and alternating diagonals. corner(i, j) returns
// the index of the vertex at lattice point (i, j) of the side. Seen from outside, the direction of
// j is 90 degrees counter-clockwise from that of i.
template <class Corner>
void add_side(MeshBuilder& builder, Index n, Corner&& corner) {
  for (Index j = 0; j < n; ++j) {
    for (Index i = 0; i < n; ++i) {
      const Index a = corner(i, j), b = corner(i + 1, j), c = corner(i + 1, j + 1),
                  d = corner(i, j + 1);
      if ((i + j) % 2 == 0) {
        builder.add(a, b, c);
        builder.add(a, c, d);
      } else {
        builder.add(a, b, d);
        builder.add(b, c, d);
      }
    }
  }
}

}  // namespace

TriangleMesh box(double x, double y, double z, Index cells_per_side) {
  require_positive(x, "x");
  require_positive(y, "y");
  require_positive(z, "z");
  require_between(cells_per_side, 1, 1000, "cells_per_side");
  const Index n = cells_per_side;
  MeshBuilder builder;
  std::map<std::array<Index, 3>, Index> known;  // vertex of each lattice point, shared along edges
  const auto vertex = [&](const std::array<Index, 3>& at) {
    const auto [entry, fresh] = known.try_emplace(at, static_cast<Index>(builder.vertices.size()));
    if (fresh) {
      builder.add(Vec3(x * (static_cast<double>(at[0]) / n - 0.5),
                       y * (static_cast<double>(at[1]) / n - 0.5),
                       z * (static_cast<double>(at[2]) / n - 0.5)));
    }
    return entry->second;
  };
  for (int axis = 0; axis < 3; ++axis) {
    for (int top = 0; top < 2; ++top) {
      // On the top side, (axis, first, second) is right-handed. On the bottom side, `first` and
      // `second` are exchanged.
      const int first = (axis + (top ? 1 : 2)) % 3, second = (axis + (top ? 2 : 1)) % 3;
      add_side(builder, n, [&](Index i, Index j) {
        std::array<Index, 3> at{};
        at[static_cast<std::size_t>(axis)] = top ? n : 0;
        at[static_cast<std::size_t>(first)] = i;
        at[static_cast<std::size_t>(second)] = j;
        return vertex(at);
      });
    }
  }
  return builder.mesh();
}

}  // namespace loomstone
