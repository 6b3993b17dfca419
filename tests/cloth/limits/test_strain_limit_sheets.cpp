// Tests of limiting the strain of sheets.
#include <catch2/catch.hpp>

#include <cmath>

#include "tests/cloth/limits/limit_support.h"

using namespace loomstone;
using namespace loomstone::test;

namespace {

constexpr double inf = std::numeric_limits<double>::infinity();

StrainLimit limits_of(double weft, double warp, double shear) {
  return {weft, warp, shear, -1.0, -1.0, std::nullopt, std::nullopt};
}

TriangleMesh irregular() { return jittered_grid(1.0, 1.0, 20, 20, 0.2, 3); }

// Returns the vertices of a sheet with non-uniform stretch, shear and waves, all proportional to
// `size`.
Points deformed(const TriangleMesh& mesh, double size) {
  Points x = mesh.vertices();
  for (Index i = 0; i < x.rows(); ++i) {
    const double u = x(i, 0), v = x(i, 1);
    x(i, 0) += size * (0.5 * u * u + 0.2 * v), x(i, 1) += size * 0.3 * std::sin(3 * u) * v,
        x(i, 2) += size * 0.1 * std::sin(4 * u + 2 * v);
  }
  return x;
}

struct Result {
  Points x;
  LimitReport report;
};
Result limited(const LimitedCloth& cloth, const Points& x, const LimitOptions& options,
               int threads = 1) {
  StrainLimiter limiter(cloth, options);
  Result r{x, {}};
  r.report = limiter.enforce({threads}, 7, {}, r.x);
  return r;
}

}  // namespace

TEST_CASE(
    "every kind of sweep brings a sheet within its limits and keeps its momentum; Gauss-Seidel "
    "takes fewer than Jacobi") {
  const TriangleMesh mesh = irregular();
  const LimitedCloth cloth = sheet(mesh, limits_of(0.05, 0.03, 0.04));
  const Points x = deformed(mesh, 0.15);
  int sweeps[3], i = 0;
  for (const char* method : {"gauss-seidel", "gauss-seidel-random", "jacobi"}) {
    const Result r = limited(cloth, x, sweeping(method));
    CHECK(r.report.beyond == 0);
    CHECK(r.report.largest() <= 1e-3);
    const Points strain = strain_of(cloth, r.x);
    CHECK(strain.col(0).maxCoeff() <= 0.051 + 1e-12);
    CHECK(strain.col(1).maxCoeff() <= 0.031 + 1e-12);
    CHECK(strain.col(2).cwiseAbs().maxCoeff() <= 0.041 + 1e-12);
    CHECK(momentum(cloth.mass, r.x - x).norm() < 1e-13);
    sweeps[i++] = r.report.sweeps;
  }
  CHECK(sweeps[0] < sweeps[2]);
  CHECK(sweeps[1] < sweeps[2]);
}

TEST_CASE("the active set gives the same bits as full sweeps with fewer evaluations") {
  const TriangleMesh mesh = irregular();
  const LimitedCloth cloth = sheet(mesh, limits_of(0.05, 0.05, 0.1), {0});
  Points x = mesh.vertices();
  for (Index i = 0; i < x.rows(); ++i)  // stretches one corner of the sheet beyond the limits
    if (x(i, 0) > 0.3 && x(i, 1) > 0.3) x(i, 0) += 0.3 * (x(i, 0) - 0.3);
  for (const char* method : {"gauss-seidel", "gauss-seidel-random", "jacobi", "edges"}) {
    const Result full = limited(cloth, x, sweeping(method, 1e-3, 2000, false)),
                 active = limited(cloth, x, sweeping(method));
    CHECK(full.report.sweeps > 3);
    CHECK(active.report.sweeps == full.report.sweeps);
    CHECK(active.x == full.x);
    CHECK(active.report.excess == full.report.excess);
    CHECK(active.report.beyond == full.report.beyond);
    CHECK(active.report.evaluations < 0.4 * full.report.evaluations);
    if (std::string(method) != "edges") CHECK(full.report.beyond == 0);
  }
}

TEST_CASE("the number of threads changes no bit") {
  const TriangleMesh mesh = jittered_grid(1.0, 1.0, 60, 60, 0.2, 3);
  const LimitedCloth cloth = sheet(mesh, limits_of(0.05, 0.03, 0.04), {0, 60});
  const Points x = deformed(mesh, 0.15);
  for (const char* method : {"gauss-seidel", "gauss-seidel-random", "jacobi", "edges"}) {
    const Result one = limited(cloth, x, sweeping(method, 1e-3, 30));
    CHECK(one.x.row(0) == x.row(0));
    CHECK(one.x.row(60) == x.row(60));
    for (const int threads : {2, 3, 7}) {
      const Result many = limited(cloth, x, sweeping(method, 1e-3, 30), threads);
      CHECK(many.x == one.x);
      CHECK(many.report.sweeps == one.report.sweeps);
      CHECK(many.report.evaluations == one.report.evaluations);
    }
  }
}

TEST_CASE("axes turned by 90 degrees swap weft and warp") {
  const TriangleMesh mesh = irregular();
  const LimitedCloth cloth = sheet(mesh, limits_of(0.02, 0.08, 0.05));
  LimitedCloth turned = cloth;
  turned.limits = {limits_of(0.08, 0.02, 0.05)};
  for (Corners2& c : turned.corners) c = (Corners2() << c.col(1), -c.col(0)).finished();
  const Points x = deformed(mesh, 0.15);
  for (const char* method : {"gauss-seidel", "jacobi"}) {
    const Result a = limited(cloth, x, sweeping(method)), b = limited(turned, x, sweeping(method));
    CHECK((a.x - b.x).cwiseAbs().maxCoeff() < 1e-9);
    const Points sa = strain_of(cloth, a.x), sb = strain_of(turned, b.x);
    CHECK((sa.col(0) - sb.col(1)).cwiseAbs().maxCoeff() < 1e-9);
    CHECK((sa.col(2) + sb.col(2)).cwiseAbs().maxCoeff() < 1e-9);
  }
}

TEST_CASE(
    "stretch limits leave a purely sheared sheet unchanged; edges cannot distinguish shear from "
    "stretch") {
  const TriangleMesh mesh = irregular();
  const LimitedCloth cloth = sheet(mesh, limits_of(0.02, 0.02, 0.3));
  Points x = mesh.vertices();
  // Applies the stretch tensor U = (1, 0.2; 0.2, 1).
  x.col(0) += 0.2 * mesh.vertices().col(1), x.col(1) += 0.2 * mesh.vertices().col(0);
  CHECK(limited(cloth, x, sweeping("gauss-seidel")).x == x);
  const Result edges = limited(cloth, x, sweeping("edges"));
  // The sheet's shear of 0.2 is within the limit of 0.3, but edge-based limiting reduces it.
  CHECK(strain_of(cloth, edges.x).col(2).cwiseAbs().mean() < 0.15);
}

TEST_CASE("limits that pins make impossible are reported with the worst element") {
  const TriangleMesh mesh = grid_cells(1.0, 1.0, 10, 10);
  std::vector<Index> pins;
  for (Index i = 0; i < mesh.n_vertices(); ++i)
    if (std::abs(mesh.vertices()(i, 0)) > 0.499) pins.push_back(i);
  const LimitedCloth cloth = sheet(mesh, limits_of(0.1, 0.1, inf), pins);
  Points x = mesh.vertices();
  x.col(0) *= 1.3;
  for (const char* method : {"gauss-seidel", "gauss-seidel-random", "jacobi"}) {
    const Result r = limited(cloth, x, sweeping(method, 1e-3, 50));
    CHECK(r.report.sweeps == 50);
    CHECK(r.report.beyond > 100);  // the pins keep the mean strain at 0.3
    REQUIRE(r.report.worst >= 0);
    const Points strain = strain_of(cloth, r.x);
    CHECK(strain.row(r.report.worst).head<2>().maxCoeff() - 0.1 ==
          Approx(r.report.largest()).epsilon(1e-9));
    for (const Index pin : pins) CHECK(r.x.row(pin) == x.row(pin));
  }
}

TEST_CASE("vertices held for one call do not move, in that call only") {
  const TriangleMesh mesh = irregular();
  const LimitedCloth cloth = sheet(mesh, limits_of(0.05, 0.03, 0.04));
  const Points x = deformed(mesh, 0.15);
  StrainLimiter limiter(cloth, sweeping("gauss-seidel"));
  Points held = x, again = x;
  limiter.enforce({}, 7, {5, 100, 101, 122}, held);
  for (const Index v : {5, 100, 101, 122}) CHECK(held.row(v) == x.row(v));
  limiter.enforce({}, 7, {}, again);
  CHECK(again == limited(cloth, x, sweeping("gauss-seidel")).x);
}

TEST_CASE("limiting brings strain rates within their bound and conserves momenta") {
  const TriangleMesh mesh = irregular();
  const LimitedCloth cloth = sheet(mesh, limits_of(0.05, 0.03, 0.04));
  const Points x = deformed(mesh, 0.1);
  // The strain rates are up to about 150/s. Their bound is 100/s: a strain of 0.1 in 1 ms.
  Points v = 100.0 * deformed(mesh, 1.0);
  const Points before = v;
  StrainLimiter limiter(cloth, sweeping("gauss-seidel"));
  const LimitReport report = limiter.enforce_rate({}, 1, x, 1e-3, v);
  CHECK(report.beyond == 0);
  CHECK(v != before);
  CHECK(momentum(cloth.mass, v - before).norm() < 1e-11);
  CHECK(angular_momentum(cloth.mass, x, v - before).norm() < 1e-11);
  // A rigid motion causes no strain rate.
  Points turning(x.rows(), 3);
  for (Index i = 0; i < x.rows(); ++i)
    turning.row(i) =
        Vec3(300, -200, 500).cross(Vec3(x.row(i))).transpose() + Vec3(9, 9, 9).transpose();
  const Points rigid = turning;
  limiter.enforce_rate({}, 1, x, 1e-3, turning);
  CHECK(turning == rigid);
}
