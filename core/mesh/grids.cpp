// Flat meshes: grids, strips, discs and floors. Their uv are their x and y coordinates as
// generated. Moving or rotating a mesh does not change its uv, so weft and warp rotate with the
// cloth.
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "core/base/message.h"
#include "core/mesh/generators.h"
#include "core/mesh/mesh_builder.h"

namespace loomstone {
namespace {

constexpr Index most_cells = 20000;  // limit per side, so that the number of vertices fits in Index

void require_count(Index count, const char* name) { require_between(count, 1, most_cells, name); }

bool alternating(const std::string& pattern) {
  if (pattern != "alternating" && pattern != "diagonal") {
    fail<InvalidInput>("pattern must be \"alternating\" or \"diagonal\", got \"{}\"; choose one",
                       pattern);
  }
  return pattern == "alternating";
}

Points grid_vertices(double width, double height, Index nx, Index ny) {
  Points vertices((nx + 1) * (ny + 1), 3);
  for (Index j = 0; j <= ny; ++j) {
    for (Index i = 0; i <= nx; ++i) {
      vertices.row(j * (nx + 1) + i) << width * (static_cast<double>(i) / nx - 0.5),
          height * (static_cast<double>(j) / ny - 0.5), 0.0;
    }
  }
  return vertices;
}

Triangles grid_triangles(Index nx, Index ny, bool checkerboard) {
  Triangles triangles(2 * nx * ny, 3);
  for (Index j = 0; j < ny; ++j) {
    for (Index i = 0; i < nx; ++i) {
      const Index a = j * (nx + 1) + i, b = a + 1, c = b + nx + 1,
                  d = a + nx + 1;  // corners in counter-clockwise order
      const Index t = 2 * (j * nx + i);
      if (checkerboard && (i + j) % 2 == 1) {
        triangles.row(t) << a, b, d;
        triangles.row(t + 1) << b, c, d;
      } else {
        triangles.row(t) << a, b, c;
        triangles.row(t + 1) << a, c, d;
      }
    }
  }
  return triangles;
}

TriangleMesh flat_mesh(const Points& vertices, const Triangles& triangles) {
  return TriangleMesh(vertices, triangles, vertices.leftCols<2>());
}

}  // namespace

TriangleMesh grid_cells(double width, double height, Index nx, Index ny,
                        const std::string& pattern) {
  require_positive(width, "width");
  require_positive(height, "height");
  require_count(nx, "nx");
  require_count(ny, "ny");
  return flat_mesh(grid_vertices(width, height, nx, ny),
                   grid_triangles(nx, ny, alternating(pattern)));
}

TriangleMesh grid(double width, double height, Index triangles, const std::string& pattern) {
  require_positive(width, "width");
  require_positive(height, "height");
  if (triangles < 2) {
    fail<InvalidInput>("triangles must be >= 2, got {}; ask for more", triangles);
  }
  // Square cells with this side give the requested number of triangles. The loops combine the two
  // whole numbers on either side of width / side with those on either side of height / side. No
  // number is less than 1.
  const double side = std::sqrt(2.0 * width * height / triangles);
  Index best_nx = 1, best_ny = 1;
  double best = std::numeric_limits<double>::infinity();
  for (int up_x = 0; up_x < 2; ++up_x) {
    for (int up_y = 0; up_y < 2; ++up_y) {
      const double nx = std::max(1.0, std::floor(width / side) + up_x),
                   ny = std::max(1.0, std::floor(height / side) + up_y);
      const double aspect = (width / nx) / (height / ny);
      // The first term is zero for square cells, the second for the requested number of triangles.
      const double miss =
          std::abs(std::log(aspect)) + std::abs(std::log(2.0 * nx * ny / triangles));
      if (miss < best - 1e-12) {
        best = miss;
        best_nx = static_cast<Index>(nx);
        best_ny = static_cast<Index>(ny);
      }
    }
  }
  return grid_cells(width, height, best_nx, best_ny, pattern);
}

TriangleMesh jittered_grid(double width, double height, Index nx, Index ny, double amount,
                           std::uint64_t seed) {
  require_positive(width, "width");
  require_positive(height, "height");
  require_count(nx, "nx");
  require_count(ny, "ny");
  // Lengths are in cells here. If the corners (0,0), (1,0), (1,1) of a triangle move by up to d in
  // each coordinate, its area is at least 1/2 (1 - 4 d). If d exceeds 1/4, the triangle may become
  // inverted.
  if (!(amount >= 0.0 && amount < 0.25)) {
    fail<InvalidInput>(
        "amount must be in [0, 0.25) of a cell, got {}; larger displacements turn "
        "triangles over",
        amount);
  }
  Points vertices = grid_vertices(width, height, nx, ny);
  std::mt19937_64 random(seed);
  // std::uniform_real_distribution is not used, because its results differ between standard
  // libraries.
  const auto draw = [&] { return 2.0 * (static_cast<double>(random() >> 11) * 0x1p-53) - 1.0; };
  for (Index j = 1; j < ny; ++j) {
    for (Index i = 1; i < nx; ++i) {
      const double dx = draw(), dy = draw();
      vertices(j * (nx + 1) + i, 0) += dx * amount * width / nx;
      vertices(j * (nx + 1) + i, 1) += dy * amount * height / ny;
    }
  }
  return flat_mesh(vertices, grid_triangles(nx, ny, true));
}

TriangleMesh strip(double length, double width, Index cells_across, const std::string& pattern) {
  require_positive(length, "length");
  require_positive(width, "width");
  require_count(cells_across, "cells_across");
  const double along = std::max(1.0, std::round(length / width * cells_across));
  if (along > most_cells) {
    fail<InvalidInput>("a strip must have at most {} cells along, got {}; lower cells_across",
                       most_cells, along);
  }
  return grid_cells(length, width, static_cast<Index>(along), cells_across, pattern);
}

TriangleMesh disc(double radius, Index rings) {
  require_positive(radius, "radius");
  require_between(rings, 1, 5000, "rings");
  // Ring r has 6 r vertices and starts at vertex 1 + 3 r (r - 1), which lies on the x axis.
  Points vertices(1 + 3 * rings * (rings + 1), 3);
  vertices.row(0).setZero();
  for (Index r = 1; r <= rings; ++r) {
    for (Index k = 0; k < 6 * r; ++k) {
      const double angle = 2.0 * M_PI * k / (6.0 * r), distance = radius * r / rings;
      vertices.row(1 + 3 * r * (r - 1) + k) << distance * std::cos(angle),
          distance * std::sin(angle), 0.0;
    }
  }
  const auto vertex = [](Index r, Index k) {
    return r == 0 ? 0 : 1 + 3 * r * (r - 1) + k % (6 * r);
  };
  Triangles triangles(6 * rings * rings, 3);
  Index t = 0;
  for (Index r = 1; r <= rings; ++r) {
    for (Index sector = 0; sector < 6; ++sector) {
      for (Index k = 0; k < r; ++k) {
        const Index outer = sector * r + k, inner = sector * (r - 1) + k;
        triangles.row(t++) << vertex(r - 1, inner), vertex(r, outer), vertex(r, outer + 1);
        if (k + 1 < r)
          triangles.row(t++) << vertex(r - 1, inner), vertex(r, outer + 1),
              vertex(r - 1, inner + 1);
      }
    }
  }
  return flat_mesh(vertices, triangles);
}

TriangleMesh floor_square(double size, Index cells) {
  require_positive(size, "size");
  require_count(cells, "cells");
  return flat_mesh(grid_vertices(size, size, cells, cells), grid_triangles(cells, cells, true));
}

}  // namespace loomstone
