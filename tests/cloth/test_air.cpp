// Tests of air drag, compared with closed forms, and of gusts.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/cloth/air.h"
#include "core/mesh/adjacency.h"
#include "core/mesh/generators.h"

using namespace loomstone;

namespace {
Points drag(const Air& air, const TriangleMesh& mesh, const Points& v) {
  const Incidence list = triangles_of_vertices(mesh.n_vertices(), mesh.triangles());
  Points f = Points::Zero(mesh.n_vertices(), 3);
  add_drag({}, air, {0.0, mesh.triangles(), list, mesh.vertices(), v}, 0, mesh.n_vertices(), f);
  return f;
}
}  // namespace

TEST_CASE("a sheet moving along its normal has a drag of density/2 C A v^2") {
  const TriangleMesh mesh = grid_cells(0.4, 0.5, 4, 5);
  Air air;
  air.normal_drag = 1.3, air.density = 1.1;
  Points v = Points::Zero(mesh.n_vertices(), 3);
  v.col(2).setConstant(-3.0);
  const Vec3 sum = drag(air, mesh, v).colwise().sum();
  CHECK(sum.z() == Approx(0.5 * 1.1 * 1.3 * 0.2 * 9.0).epsilon(1e-12));
  CHECK(std::hypot(sum.x(), sum.y()) < 1e-15);
}

TEST_CASE(
    "along the sheet only the tangential coefficient acts, and at the wind's velocity there is no "
    "drag") {
  const TriangleMesh mesh = grid_cells(0.4, 0.5, 4, 5);
  Air air;
  air.normal_drag = 1.3, air.tangential_drag = 0.1, air.wind = Vec3(2, 0, 0);
  Points v = Points::Zero(mesh.n_vertices(), 3);
  CHECK(drag(air, mesh, v).col(0).sum() == Approx(0.5 * 1.2 * 0.1 * 0.2 * 4.0).epsilon(1e-12));
  v.col(0).setConstant(2.0);
  CHECK(drag(air, mesh, v).norm() == 0.0);
}

TEST_CASE("the rate of drag is the drag divided by mass and relative velocity") {
  const TriangleMesh mesh = grid_cells(0.4, 0.5, 4, 5);
  const Incidence list = triangles_of_vertices(mesh.n_vertices(), mesh.triangles());
  Air air;
  air.normal_drag = 1.3, air.tangential_drag = 0.2, air.wind = Vec3(0.5, 0, 2);
  const Points v = Points::Zero(mesh.n_vertices(), 3);
  const DraggedSurface surface{0.0, mesh.triangles(), list, mesh.vertices(), v};
  const Index n = mesh.n_vertices();
  // One vertex is far lighter than the others, so its rate of drag is the largest.
  Vector mass = Vector::Constant(n, 1e-3);
  mass[7] = 1e-6;
  // All triangles of the grid have the same area.
  const double area = 0.5 * 0.1 * 0.1 * (list.start[8] - list.start[7]);
  const double wanted = 0.5 * 1.2 * area / 3.0 * (1.3 * 2.0 + 0.2 * 0.5) / 1e-6;
  CHECK(drag_rate({}, air, surface, mass, 0, n) == Approx(wanted).epsilon(1e-12));
  CHECK(drag_rate({}, air, surface, mass, 8, n) < 3e-3 * wanted);
  CHECK(drag_rate({}, air, surface, mass, 3, 3) == 0.0);
}

TEST_CASE("drag follows v = v_t tanh(g t / v_t) for a sheet falling flat") {
  // The sheet obeys m dv/dt = m g - c v^2 with c = rho C A / 2. Here rho is the density of the air,
  // C is normal_drag, and A is the area. From rest, the solution is
  //   v = v_t tanh(g t / v_t) with v_t = sqrt(m g / c).
  const TriangleMesh mesh = grid_cells(0.4, 0.5, 2, 2);
  Air air;
  air.normal_drag = 1.0;
  const double mass = 0.06, g = 9.81, c = 0.5 * 1.2 * 0.2, terminal = std::sqrt(mass * g / c);
  double speed = 0.0;
  const double h = 1e-4;
  Points v = Points::Zero(mesh.n_vertices(), 3);
  for (int i = 0; i < 5000; ++i) {
    v.col(2).setConstant(-speed);
    speed += h * (g - drag(air, mesh, v).col(2).sum() / mass);
  }
  // The tolerance covers the error of the scheme, which is of first order in the step h.
  CHECK(speed == Approx(terminal * std::tanh(g * 0.5 / terminal)).epsilon(2e-4));
}

TEST_CASE("gusts change the wind's speed by at most their share") {
  Air air;
  air.wind = Vec3(3, 0, 0), air.gust = 0.5;
  for (double t = 0; t < 5; t += 0.01) {
    const double speed = wind_at(air, Vec3(0.1, 0.2, 0.3), t).x();
    CHECK(speed >= 1.5);
    CHECK(speed <= 4.5);
  }
}

TEST_CASE("gusts turn with the wind about the vertical axis") {
  const Mat3 turn = Eigen::AngleAxisd(1.1, Vec3::UnitZ()).toRotationMatrix();
  Air air, turned;
  air.wind = Vec3(3, -1, 0.5), turned.wind = turn * air.wind;
  air.gust = turned.gust = 0.5;
  for (double t = 0; t < 5; t += 0.1) {
    const Vec3 place(0.3 * t, 0.2, 0.7 - 0.1 * t);
    CHECK((wind_at(turned, turn * place, t) - turn * wind_at(air, place, t)).norm() < 1e-12);
  }
}

TEST_CASE("gusts along every axis vary across the wind") {
  for (int axis = 0; axis < 3; ++axis) {
    Air air;
    air.wind = 3.0 * Vec3::Unit(axis), air.gust = 0.5;
    for (int other = 0; other < 3; ++other) {
      if (other == axis) continue;
      const Vec3 here = wind_at(air, Vec3::Zero(), 1.0);
      CHECK((wind_at(air, 0.4 * Vec3::Unit(other), 1.0) - here).norm() > 0.01);
    }
  }
}
