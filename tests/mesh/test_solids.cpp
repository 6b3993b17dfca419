#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/mesh/adjacency.h"
#include "core/mesh/generators.h"

namespace loomstone {
namespace {

struct Measures {
  double volume = 0.0;           // [m^3], positive if the faces point outward
  double smallest_angle = M_PI;  // [rad]
  Index euler = 0;
};

Measures measure(const TriangleMesh& mesh) {
  Measures result;
  for (Index t = 0; t < mesh.n_triangles(); ++t) {
    Vec3 x[3];
    for (int c = 0; c < 3; ++c) x[c] = mesh.vertices().row(mesh.triangles()(t, c)).transpose();
    result.volume += x[0].dot(x[1].cross(x[2])) / 6.0;
    for (int c = 0; c < 3; ++c) {
      const Vec3 a = (x[(c + 1) % 3] - x[c]).normalized(), b = (x[(c + 2) % 3] - x[c]).normalized();
      result.smallest_angle =
          std::min(result.smallest_angle, std::acos(std::clamp(a.dot(b), -1.0, 1.0)));
    }
  }
  const EdgeTable table = edge_table(mesh.n_vertices(), mesh.triangles());
  result.euler = mesh.n_vertices() - static_cast<Index>(table.edges.rows()) + mesh.n_triangles();
  return result;
}

constexpr double degree = M_PI / 180.0;

}  // namespace

TEST_CASE(
    "closed generators face outward, are closed, and have volume and Euler characteristic of their "
    "kind") {
  // The volume of the funnel's wall follows from Pappus's theorem. `section` is the sum of area
  // times centroid radius over the parts of the wall's cross-section. The kite in which cone and
  // tube overlap is subtracted, and each rim adds half a disc.
  const double top = 0.3, bottom = 0.1, height = 0.2, tube = 0.15, wall = 0.02,
               s = std::sqrt(0.5);  // sine and cosine of the cone's 45 degrees
  const double half_disc = M_PI * wall * wall / 8.0;
  const double section = wall * height / s * (0.5 * (top + bottom) + 0.5 * wall * s) +
                         wall * tube * (bottom + 0.5 * wall) -
                         wall * wall * std::tan(M_PI / 8.0) * (bottom + wall * (3.0 + s) / 6.0) +
                         half_disc * (top + 0.5 * wall * s + 2.0 * wall / (3.0 * M_PI) * s) +
                         half_disc * (bottom + 0.5 * wall);
  // Length of the wave bar's centre line z = 0.05 cos(4 pi y) over one metre.
  double way = 0.0;
  for (int i = 0; i < 1000; ++i)
    way += std::hypot(1.0, 0.2 * M_PI * std::sin(4.0 * M_PI * (i + 0.5) / 1000.0)) / 1000.0;
  struct Case {
    const char* name;
    TriangleMesh mesh;
    double volume;  // exact volume of the body that the mesh represents [m^3]
    double tolerance;
    Index euler;            // 2 for a sphere, 0 for a ring
    double smallest_angle;  // lower bound [rad]; slivers harm contacts
  };
  // Most tolerances follow from the approximation of circles: an inscribed n-gon lacks the fraction
  // 2 pi^2 / (3 n^2) of the circle's area. Spheres and rims lack more, because they are curved in a
  // second direction. For bodies with flat faces, the tolerance covers rounding.
  const Case cases[] = {
      {"icosphere", icosphere(0.5, 4), M_PI / 6.0, 0.003, 2, 53.0 * degree},
      {"cube", box(1.0, 1.0, 1.0, 4), 1.0, 1e-12, 2, 44.9 * degree},
      {"box", box(1.0, 2.0, 3.0, 1), 6.0, 1e-12, 2, 18.0 * degree},
      {"capsule", capsule(1.0, 3.0, 48), (4.0 / 3.0 + 3.0) * M_PI, 0.005, 2, 40.0 * degree},
      {"coarse capsule", capsule(1.0, 1.0, 12), (4.0 / 3.0 + 1.0) * M_PI, 0.1, 2, 30.0 * degree},
      {"cylinder", cylinder(1.0, 3.0, 48), 3.0 * M_PI, 0.005, 2, 30.0 * degree},
      {"triangular prism", cylinder(1.0, 1.0, 3), 0.75 * std::sqrt(3.0), 1e-12, 2, 25.0 * degree},
      {"funnel", funnel(top, bottom, height, tube, wall, 96), 2.0 * M_PI * section, 0.006, 0,
       25.0 * degree},
      {"wave bar", wave_bar(1.0, 0.02, 0.05, 0.5, 32),
       M_PI * 0.0004 * way + M_PI * 4.0 / 3.0 * 8e-6, 0.007, 2, 40.0 * degree}};
  for (const Case& each : cases) {
    INFO(each.name);
    const Measures found = measure(each.mesh);
    CHECK(each.mesh.closed());
    CHECK(found.euler == each.euler);
    CHECK(found.volume == Approx(each.volume).epsilon(each.tolerance));
    CHECK(found.smallest_angle > each.smallest_angle);
  }
}

TEST_CASE("spheres have their vertices on the sphere and 20 * 4^level triangles") {
  const TriangleMesh mesh = icosphere(0.25, 3);
  CHECK(mesh.n_triangles() == 20 * 64);
  CHECK(mesh.n_vertices() == 10 * 64 + 2);
  for (Index v = 0; v < mesh.n_vertices(); ++v)
    CHECK(mesh.vertices().row(v).norm() == Approx(0.25).epsilon(1e-15));
}

TEST_CASE("boxes and capsules extend exactly to their dimensions in both directions") {
  const TriangleMesh cuboid = box(1.0, 2.0, 3.0, 3), pill = capsule(0.5, 2.0, 24);
  CHECK(cuboid.n_triangles() == 6 * 9 * 2);
  CHECK(cuboid.vertices().colwise().maxCoeff() == Eigen::RowVector3d(0.5, 1.0, 1.5));
  CHECK(cuboid.vertices().colwise().minCoeff() == Eigen::RowVector3d(-0.5, -1.0, -1.5));
  CHECK(pill.vertices().col(2).maxCoeff() == 1.5);
  CHECK(pill.vertices().col(2).minCoeff() == -1.5);
}

TEST_CASE("a funnel is open inside: nothing lies nearer to the axis than its inner wall") {
  const TriangleMesh mesh = funnel(0.3, 0.1, 0.2, 0.15, 0.005);
  for (Index v = 0; v < mesh.n_vertices(); ++v) {
    const Vec3 x = mesh.vertices().row(v);
    const double inner = x.z() <= 0.0 ? 0.1 : 0.1 + x.z();  // a cone of 45 degrees
    CHECK(x.head<2>().norm() >= inner - 1e-12);
    CHECK(x.z() >= -0.15 - 0.0025 - 1e-12);
  }
}

TEST_CASE(
    "a wave bar keeps its radius around its wavy centre line, and a straight one is a capsule") {
  const double k = 2.0 * M_PI / 0.4;
  const TriangleMesh mesh = wave_bar(1.2, 0.02, 0.05, 0.4, 16);
  for (Index v = 0; v < mesh.n_vertices(); ++v) {
    const Vec3 x = mesh.vertices().row(v);
    double nearest = 1.0;
    for (int i = 0; i <= 2400; ++i) {
      const double y = 1.2 * (i / 2400.0 - 0.5);
      nearest = std::min(nearest, (x - Vec3(0.0, y, 0.05 * std::cos(k * y))).norm());
    }
    // The tolerance covers the sampling of the centre line at every half millimetre.
    CHECK(nearest == Approx(0.02).epsilon(1e-3));
  }
  CHECK(measure(wave_bar(1.0, 0.1, 0.0, 1.0, 24)).volume ==
        Approx(measure(capsule(0.1, 1.0, 24)).volume).epsilon(1e-12));
}

TEST_CASE("closed generators refuse invalid numbers by name") {
  CHECK_THROWS_AS(icosphere(0.0, 1), InvalidInput);
  CHECK_THROWS_WITH(icosphere(-1.0, 1), Catch::Contains("radius must be > 0"));
  CHECK_THROWS_WITH(icosphere(1.0, 9), Catch::Contains("subdivisions must be 0 to 8, got 9"));
  CHECK_THROWS_WITH(box(1.0, 0.0, 1.0), Catch::Contains("y must be > 0"));
  CHECK_THROWS_WITH(box(1.0, 1.0, 1.0, 0), Catch::Contains("cells_per_side must be 1 to 1000"));
  CHECK_THROWS_WITH(capsule(1.0, 0.0), Catch::Contains("length must be > 0"));
  CHECK_THROWS_WITH(capsule(1.0, 1.0, 5), Catch::Contains("segments must be 6 to 4096"));
  CHECK_THROWS_WITH(cylinder(1.0, 1.0, 2), Catch::Contains("segments must be 3 to 4096"));
  CHECK_THROWS_WITH(funnel(0.1, 0.2, 1.0, 1.0, 0.01),
                    Catch::Contains("top_radius must be > bottom_radius"));
  CHECK_THROWS_WITH(funnel(0.3, 0.1, 0.01, 0.001, 0.05), Catch::Contains("tube_length must be >"));
  CHECK_THROWS_WITH(wave_bar(1.0, 0.01, -0.1, 1.0), Catch::Contains("amplitude must be >= 0"));
  CHECK_THROWS_WITH(wave_bar(1.0, 0.1, 0.1, 0.2), Catch::Contains("smallest radius of curvature"));
}

}  // namespace loomstone
