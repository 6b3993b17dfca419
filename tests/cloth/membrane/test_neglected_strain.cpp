// Tests of the strain that a linear model neglects, and of the omission of its stress from the
// geometric term of the Jacobian.
#include <catch2/catch.hpp>

#include "tests/cloth/membrane_support.h"

using namespace loomstone;

namespace {

// Returns 1/2 dF^T dF of each triangle (m x 3: 11, 22, 12), where dF is the gradient of the
// displacement u. It follows from Green strains: E(x + u) + E(x - u) - 2 E(x) = dF^T dF.
Points second_order_strains(Membrane& membrane, const Points& x, const Points& u) {
  Points ahead, behind, here;
  Vector stretch;
  membrane.strain({}, x + u, ahead, stretch);
  membrane.strain({}, x - u, behind, stretch);
  membrane.strain({}, x, here, stretch);
  return 0.5 * (ahead + behind) - here;
}

double largest_eigenvalue(const Vec3& e) {
  return 0.5 * (e[0] + e[1]) + std::hypot(0.5 * (e[0] - e[1]), e[2]);
}

Vec3 stress(const MembraneConstants& m, const Vec3& e) {
  return {m.a11 * e[0] + m.a12 * e[1], m.a22 * e[1] + m.a12 * e[0], 2.0 * m.g * e[2]};
}

double contraction(const Vec3& s, const Vec3& e) {
  return s[0] * e[0] + s[1] * e[1] + 2.0 * s[2] * e[2];
}

// Rest area of each triangle [m^2].
std::vector<double> rest_areas(const TriangleMesh& mesh) {
  std::vector<double> areas;
  for (const Corners2& c : rest_corners(mesh, true, "mesh")) {
    Mat2 edges;
    edges << c.row(1) - c.row(0), c.row(2) - c.row(0);
    areas.push_back(0.5 * edges.determinant());
  }
  return areas;
}

// Returns u^T (A - B) u. A is the stiffness matrix at x. In B, the geometric term omits the stress
// of the neglected strain of the motion `past`.
double quadratic_difference(Sheet& s, const Points& x, const Points& u, PastMotion past) {
  const Index n = s.mesh.n_vertices();
  BlockMatrix whole = pattern(s.mesh), without = pattern(s.mesh);
  s.membrane.set_jacobian({}, x, {JacobianKind::Exact, {1.0, 0.0}}, 0, n, whole);
  s.membrane.set_jacobian({}, x, {JacobianKind::Exact, {1.0, 0.0}, past}, 0, n, without);
  const Eigen::VectorXd flat = Eigen::Map<const Eigen::VectorXd>(u.data(), 3 * n);
  return flat.dot((dense(whole) - dense(without)) * flat);
}

}  // namespace

TEST_CASE("the neglected strain is 1/2 dF^T dF, for each range of triangles by itself") {
  Sheet s = make_sheet(orthotropic());
  const Index m = s.mesh.n_triangles();
  const std::vector<double> area = rest_areas(s.mesh);
  const MembraneConstants constants = membrane_constants(orthotropic(), "material");
  const Points x = deformed(s.mesh, 1), u = random_points(s.mesh.n_vertices(), 0.01, 2);
  const Points e = second_order_strains(s.membrane, x, u);
  const std::vector<Index> ranges = {0, m / 3, m};
  const Points end = x + u;
  for (std::size_t r = 0; r < 2; ++r) {
    const auto found = s.membrane.neglected(nullptr, u.data(), ranges[r], ranges[r + 1]);
    const auto moved = s.membrane.neglected(x.data(), end.data(), ranges[r], ranges[r + 1]);
    double largest = 0.0, energy = 0.0;
    for (Index t = ranges[r]; t < ranges[r + 1]; ++t) {
      const Vec3 strain = e.row(t).transpose();
      largest = std::max(largest, largest_eigenvalue(strain));
      energy += 0.5 * area[t] * contraction(stress(constants, strain), strain);
    }
    // 1/2 dF^T dF, of order 0.1, is computed as a difference of Green strains of order 1, whose
    // rounding errors are about 1e-15.
    CHECK(found.strain == Approx(largest).epsilon(1e-12));
    CHECK(found.energy == Approx(energy).epsilon(1e-12));
    CHECK(moved.strain == Approx(largest).epsilon(1e-12));
    CHECK(moved.energy == Approx(energy).epsilon(1e-12));
  }
}

TEST_CASE("the geometric term leaves out the stress of a past motion's neglected strain") {
  Sheet s = make_sheet(orthotropic());
  const MembraneConstants constants = membrane_constants(orthotropic(), "material");
  const Index n = s.mesh.n_vertices();
  const Points x = deformed(s.mesh, 3), u = random_points(n, 0.01, 4);
  const Points v = random_points(n, 0.2, 5);
  const double step = 4e-3;
  const Points past = second_order_strains(s.membrane, x, step * v);
  const std::vector<double> area = rest_areas(s.mesh);
  const Points quadratic = 2.0 * second_order_strains(s.membrane, x, u);  // dF^T dF
  double expected = 0.0, largest = 0.0;
  for (Index t = 0; t < s.mesh.n_triangles(); ++t) {
    const Vec3 strain = past.row(t).transpose();
    largest = std::max(largest, largest_eigenvalue(strain));
    expected +=
        area[t] * contraction(stress(constants, strain), Vec3(quadratic.row(t).transpose()));
  }
  REQUIRE(largest < 0.01);  // neglected strains of up to 0.01 are omitted in full
  // The tolerance covers rounding: the strains of the past motion, of order 1e-3, are computed as
  // differences of strains of order 1.
  CHECK(quadratic_difference(s, x, u, {v.data(), step}) == Approx(expected).epsilon(1e-9));
}

TEST_CASE("the strain that the geometric term leaves out is at most 0.01") {
  Sheet s = make_sheet(orthotropic());
  const Index n = s.mesh.n_vertices();
  const Points x = deformed(s.mesh, 3), u = random_points(n, 0.01, 4);
  const Points v = random_points(n, 500.0, 5);  // strains every triangle by far more than 0.01
  const double once = quadratic_difference(s, x, u, {v.data(), 1e-3});
  const double longer = quadratic_difference(s, x, u, {v.data(), 4e-3});
  CHECK(once > 0.0);
  CHECK(longer == Approx(once).epsilon(1e-9));
}
