#include <catch2/catch.hpp>

#include <cmath>

#include "core/base/error.h"
#include "core/mesh/generators.h"

namespace loomstone {
namespace {

double signed_area(const Corners2& x) {
  return 0.5 *
         ((x(1, 0) - x(0, 0)) * (x(2, 1) - x(0, 1)) - (x(2, 0) - x(0, 0)) * (x(1, 1) - x(0, 1)));
}

// Largest difference between the lengths of an edge of triangle t in space and at rest [m].
double stretch_error(const TriangleMesh& mesh, Index t, const Corners2& rest) {
  double worst = 0.0;
  for (int c = 0; c < 3; ++c) {
    const Vec3 edge = mesh.vertices().row(mesh.triangles()(t, (c + 1) % 3)) -
                      mesh.vertices().row(mesh.triangles()(t, c));
    worst = std::max(worst, std::abs(edge.norm() - (rest.row((c + 1) % 3) - rest.row(c)).norm()));
  }
  return worst;
}

TriangleMesh without_uv(const TriangleMesh& mesh) {
  return TriangleMesh(mesh.vertices(), mesh.triangles());
}

const Mat3 some_turn = Eigen::AngleAxisd(0.9, Vec3(1, -2, 1).normalized()).toRotationMatrix();
constexpr double coordinate_rounding = 1e-14;  // rounding error of coordinates of order one

}  // namespace

TEST_CASE("with uv as the pattern, rest corners are the uv") {
  const TriangleMesh mesh = jittered_grid(1.0, 0.5, 6, 3, 0.2).moved(Vec3(1, 2, 3), some_turn, 3.0);
  const std::vector<Corners2> rest = rest_corners(mesh, true, "cloths[0].mesh");
  for (Index t = 0; t < mesh.n_triangles(); ++t) {
    for (int c = 0; c < 3; ++c) {
      CHECK(rest[static_cast<std::size_t>(t)].row(c) == mesh.uv().row(mesh.uv_triangles()(t, c)));
    }
  }
}

TEST_CASE(
    "with uv for directions only, rest corners have the lengths of the mesh and weft along growing "
    "u") {
  const TriangleMesh flat = jittered_grid(1.0, 0.5, 6, 3, 0.2);
  const double angle = 0.6;
  Mat2 turn;
  turn << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  // The uv are the coordinates of `flat`, rotated by `angle` and scaled by 5.
  Points2 uv = flat.vertices().leftCols<2>() * turn.transpose() * 5.0;
  const TriangleMesh mesh =
      TriangleMesh(flat.vertices(), flat.triangles(), uv).moved(Vec3(1, 2, 3), some_turn);
  const std::vector<Corners2> rest = rest_corners(mesh, false, "mesh");
  for (Index t = 0; t < mesh.n_triangles(); ++t) {
    const Corners2& corners = rest[static_cast<std::size_t>(t)];
    CHECK(signed_area(corners) > 0.0);
    CHECK(stretch_error(mesh, t, corners) < coordinate_rounding * 10);
    for (int c = 1; c < 3; ++c) {
      const Vec2 expected = (uv.row(mesh.triangles()(t, c)) - uv.row(mesh.triangles()(t, 0))) / 5.0;
      // The direction of weft comes from differences of coordinates, which amplify rounding.
      CHECK((Vec2(corners.row(c) - corners.row(0)) - expected).norm() < 1e-12);
    }
  }
}

TEST_CASE("a mirrored panel gets rest corners of positive area, with warp along growing v") {
  const TriangleMesh flat = jittered_grid(1.0, 1.0, 4, 4, 0.2);
  Points2 uv = flat.uv();
  uv.col(0) *= -1.0;
  const TriangleMesh mesh(flat.vertices(), flat.triangles(), uv);
  for (const bool from_uv : {true, false}) {
    const std::vector<Corners2> rest = rest_corners(mesh, from_uv, "mesh");
    for (Index t = 0; t < mesh.n_triangles(); ++t) {
      const Corners2& corners = rest[static_cast<std::size_t>(t)];
      CHECK(signed_area(corners) > 0.0);
      CHECK(stretch_error(mesh, t, corners) < 1e-12);
      for (int c = 1; c < 3; ++c) {
        const double warp = uv(mesh.triangles()(t, c), 1) - uv(mesh.triangles()(t, 0), 1);
        CHECK(corners(c, 1) - corners(0, 1) == Approx(warp).margin(1e-12));
      }
    }
  }
}

TEST_CASE(
    "a flat mesh without uv uses its own plane, weft along the world's x, or y where the plane "
    "faces x") {
  const TriangleMesh flat = without_uv(jittered_grid(1.0, 1.0, 4, 4, 0.2));
  const std::vector<Corners2> rest = rest_corners(flat, true, "mesh");
  const Mat3 to_yz = (Mat3() << 0, 0, 1, 1, 0, 0, 0, 1, 0).finished();  // x -> y, y -> z, z -> x
  const TriangleMesh facing_x = flat.moved(Vec3::Zero(), to_yz);
  const std::vector<Corners2> rest_x = rest_corners(facing_x, true, "mesh");
  const TriangleMesh tilted = flat.moved(Vec3(3, 1, 4), some_turn);
  const std::vector<Corners2> rest_tilted = rest_corners(tilted, false, "mesh");
  for (Index t = 0; t < flat.n_triangles(); ++t) {
    const std::size_t i = static_cast<std::size_t>(t);
    for (int c = 0; c < 3; ++c) {
      CHECK(rest[i].row(c) == flat.vertices().row(flat.triangles()(t, c)).head<2>());
      CHECK((rest_x[i].row(c) - flat.vertices().row(flat.triangles()(t, c)).head<2>()).norm() <
            coordinate_rounding);
    }
    CHECK(signed_area(rest_tilted[i]) > 0.0);
    CHECK(stretch_error(tilted, t, rest_tilted[i]) < 1e-13);
  }
}

TEST_CASE("a curved mesh without uv is refused, saying where and what to do") {
  CHECK_THROWS_AS(rest_corners(icosphere(1.0, 1), false, "cloths[3].mesh"), InvalidInput);
  CHECK_THROWS_WITH(
      rest_corners(icosphere(1.0, 1), false, "cloths[3].mesh"),
      Catch::Contains("cloths[3].mesh must have uv or be flat") && Catch::Contains("give uv"));
}

}  // namespace loomstone
