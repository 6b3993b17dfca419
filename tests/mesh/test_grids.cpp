#include <catch2/catch.hpp>

#include <cmath>

#include "core/base/error.h"
#include "core/mesh/adjacency.h"
#include "core/mesh/generators.h"

namespace loomstone {
namespace {

// Total area of the triangles, all of which must face +z.
double flat_area(const TriangleMesh& mesh) {
  double sum = 0.0;
  for (Index t = 0; t < mesh.n_triangles(); ++t) {
    const Vec3 a = mesh.vertices().row(mesh.triangles()(t, 0)),
               b = mesh.vertices().row(mesh.triangles()(t, 1)),
               c = mesh.vertices().row(mesh.triangles()(t, 2));
    const double area = 0.5 * (b - a).cross(c - a).z();
    REQUIRE(area > 0.0);
    sum += area;
  }
  return sum;
}

Index euler_characteristic(const TriangleMesh& mesh) {
  const EdgeTable table = edge_table(mesh.n_vertices(), mesh.triangles());
  return mesh.n_vertices() - static_cast<Index>(table.edges.rows()) + mesh.n_triangles();
}

constexpr double rounding = 1e-12;  // rounding error of sums of a few thousand doubles of order one

}  // namespace

TEST_CASE("a grid numbers vertex j (nx + 1) + i at column i and row j") {
  const TriangleMesh mesh = grid_cells(2.0, 3.0, 4, 6);
  REQUIRE(mesh.n_vertices() == 35);
  REQUIRE(mesh.n_triangles() == 48);
  for (Index j = 0; j <= 6; ++j) {
    for (Index i = 0; i <= 4; ++i) {
      const Vec3 expected(-1.0 + 0.5 * i, -1.5 + 0.5 * j, 0.0);
      CHECK((mesh.vertices().row(j * 5 + i).transpose() - expected).norm() < rounding);
    }
  }
}

TEST_CASE(
    "flat meshes have the area of their outline, face +z, are discs, and carry their coordinates "
    "as uv") {
  // Area of a regular hexagon inscribed in a circle of radius 1.
  const double hexagon_like = 3.0 * std::sin(M_PI / 3.0);
  struct Case {
    TriangleMesh mesh;
    double area;
  };
  const Case cases[] = {{grid_cells(2.0, 3.0, 5, 7), 6.0},
                        {grid_cells(2.0, 3.0, 5, 7, "diagonal"), 6.0},
                        {jittered_grid(1.0, 1.5, 20, 30, 0.24, 7), 1.5},
                        {strip(1.0, 0.2, 6), 0.2},
                        {disc(1.0, 1), hexagon_like},
                        {disc(2.0, 8), 4.0 * 24.0 * std::sin(2.0 * M_PI / 48.0)}};
  for (const Case& each : cases) {
    CHECK(flat_area(each.mesh) == Approx(each.area).epsilon(rounding));
    CHECK(euler_characteristic(each.mesh) == 1);
    CHECK_FALSE(each.mesh.closed());
    CHECK(each.mesh.flat());
    CHECK(each.mesh.uv() == each.mesh.vertices().leftCols<2>());
  }
}

TEST_CASE("the alternating pattern turns the diagonal from cell to cell, the other one does not") {
  const auto has_edge = [](const TriangleMesh& mesh, Index a, Index b) {
    const EdgeTable table = edge_table(mesh.n_vertices(), mesh.triangles());
    for (Eigen::Index e = 0; e < table.edges.rows(); ++e) {
      if (table.edges(e, 0) == a && table.edges(e, 1) == b) return true;
    }
    return false;
  };
  const TriangleMesh turned = grid_cells(1.0, 1.0, 2, 1),
                     straight = grid_cells(1.0, 1.0, 2, 1, "diagonal");
  CHECK(has_edge(turned, 0, 4));
  CHECK(has_edge(turned, 2, 4));
  CHECK(has_edge(straight, 0, 4));
  CHECK(has_edge(straight, 1, 5));
}

TEST_CASE(
    "a grid requested by its number of triangles has about that number, with nearly square cells") {
  CHECK(grid(0.5, 0.5, 14476).n_triangles() == 2 * 85 * 85);
  CHECK(grid(1.0, 1.0, 2).n_triangles() == 2);
  const TriangleMesh wide = grid(3.0, 1.0, 600);
  CHECK(wide.n_triangles() == 600);
  // The tolerance allows for the border, where there are more grid edges per diagonal.
  CHECK(wide.mean_edge() == Approx(0.1 * (2.0 + std::sqrt(2.0)) / 3.0).epsilon(0.02));
}

TEST_CASE(
    "jittered grids are the same for the same seed, differ for another, and keep their border") {
  const TriangleMesh a = jittered_grid(1.0, 1.0, 8, 8, 0.2, 3),
                     b = jittered_grid(1.0, 1.0, 8, 8, 0.2, 3),
                     c = jittered_grid(1.0, 1.0, 8, 8, 0.2, 4), even = grid_cells(1.0, 1.0, 8, 8);
  CHECK(a.vertices() == b.vertices());
  CHECK(a.vertices() != c.vertices());
  for (Index i = 0; i <= 8; ++i) CHECK(a.vertices().row(i) == even.vertices().row(i));
}

TEST_CASE("a floor faces up, has its coordinates in metres as uv and is open") {
  const TriangleMesh mesh = floor_square(4.0, 3);
  CHECK(flat_area(mesh) == Approx(16.0).epsilon(rounding));
  CHECK(mesh.uv() == mesh.vertices().leftCols<2>());
  CHECK_FALSE(mesh.closed());
}

TEST_CASE("flat generators refuse invalid numbers by name") {
  CHECK_THROWS_WITH(grid_cells(0.0, 1.0, 2, 2), Catch::Contains("width must be > 0"));
  CHECK_THROWS_WITH(grid_cells(1.0, std::nan(""), 2, 2), Catch::Contains("height must be > 0"));
  CHECK_THROWS_WITH(grid_cells(1.0, 1.0, 0, 2), Catch::Contains("nx must be 1 to 20000, got 0"));
  CHECK_THROWS_WITH(grid_cells(1.0, 1.0, 2, 2, "x"),
                    Catch::Contains("pattern must be") && Catch::Contains("\"x\""));
  CHECK_THROWS_WITH(grid(1.0, 1.0, 1), Catch::Contains("triangles must be >= 2"));
  CHECK_THROWS_WITH(jittered_grid(1.0, 1.0, 4, 4, 0.3),
                    Catch::Contains("amount must be in [0, 0.25)"));
  CHECK_THROWS_WITH(strip(1e6, 1.0, 2), Catch::Contains("at most 20000 cells along"));
  CHECK_THROWS_WITH(disc(1.0, 5001), Catch::Contains("rings must be 1 to 5000"));
  CHECK_THROWS_AS(disc(-1.0, 3), InvalidInput);
}

}  // namespace loomstone
