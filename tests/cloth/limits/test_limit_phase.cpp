// Tests of the stiff phases of the membrane near strain limits.
#include <catch2/catch.hpp>

#include "core/cloth/limits/limit_phase.h"
#include "tests/cloth/membrane_support.h"
#include "tests/support/decompositions.h"

using namespace loomstone;

namespace {

LimitPhase phase_of(Sheet& s, const StrainLimit& limit) {
  return LimitPhase(s.membrane, {limit}, std::vector<Index>(s.mesh.n_triangles(), 0));
}

// Upper and lower limits. Many strain components of the shape deformed() lie beyond them.
StrainLimit exceeded() {
  StrainLimit limit;
  limit.weft = 0.15, limit.warp = 0.15, limit.shear = 0.05;
  limit.weft_min = -0.1, limit.warp_min = -0.1;
  return limit;
}

StrainLimit weft_limit() {
  StrainLimit limit;
  limit.weft = 0.1;
  return limit;
}

Sheet isotropic_sheet() {
  ClothMaterial material;
  material.weft_stiffness = 300, material.warp_stiffness = 300, material.shear_stiffness = 150,
  material.poisson = 0.0;
  return make_sheet(material);
}

// Returns the vertices of a sheet that is stretched uniformly along weft.
Points stretched(const TriangleMesh& mesh, double strain) {
  Points x = mesh.vertices();
  x.col(0) *= 1.0 + strain;
  return x;
}

double tension(Sheet& s, const Points& x) {
  const Points f = force_of(s.membrane, x);
  double sum = 0.0;
  for (Index i = 0; i < x.rows(); ++i)
    if (s.mesh.vertices()(i, 0) < 1e-12) sum += f(i, 0);
  return sum;
}

}  // namespace

TEST_CASE("within its limits a sheet has no second phase") {
  Sheet s = make_sheet(orthotropic());
  StrainLimit limit;  // wide enough for all strains of the deformed sheet
  limit.weft = limit.warp = 2.0, limit.shear = 1.0;
  limit.weft_min = limit.warp_min = -0.9;
  LimitPhase phase = phase_of(s, limit);
  const Points x = deformed(s.mesh, 1), before = force_of(s.membrane, x);
  phase.enter({}, x, 0, s.mesh.n_vertices());
  s.membrane.set_phase(phase.table(), phase.entered());
  CHECK(force_of(s.membrane, x) == before);
}

TEST_CASE("the second phase has forces of its energy and the Jacobian of its forces") {
  Sheet s = make_sheet(orthotropic());
  const Index n = s.mesh.n_vertices();
  const Points x = deformed(s.mesh, 1), d = random_points(n, 1.0, 2),
               without = force_of(s.membrane, x);
  LimitPhase phase = phase_of(s, exceeded());
  phase.enter({}, x, 0, s.mesh.n_vertices());
  s.membrane.set_phase(phase.table(), phase.entered());
  REQUIRE((force_of(s.membrane, x) - without).norm() > 10.0 * without.norm());
  BlockMatrix k = pattern(s.mesh);
  s.membrane.set_jacobian({}, x, {JacobianKind::Exact, {1.0, 0.0}}, 0, n, k);
  const Eigen::VectorXd product = dense(k) * Eigen::Map<const Eigen::VectorXd>(d.data(), 3 * n);
  const double slope = -dot(force_of(s.membrane, x), d);
  double force_before = 0.0, jacobian_before = 0.0;
  for (const double step :
       {1e-4, 1e-5, 1e-6}) {  // central differences: second order until rounding dominates
    const Points up = x + step * d, down = x - step * d;
    const double force_error = std::abs(
        (s.membrane.energy({}, up) - s.membrane.energy({}, down)) / (2 * step) / slope - 1.0);
    const Points change = (force_of(s.membrane, down) - force_of(s.membrane, up)) / (2 * step);
    const double jacobian_error =
        (Eigen::Map<const Eigen::VectorXd>(change.data(), 3 * n) - product).norm() / product.norm();
    if (force_before > 1e-9) CHECK(force_error < force_before / 90.0 + 1e-10);
    if (jacobian_before > 1e-9) CHECK(jacobian_error < jacobian_before / 90.0 + 1e-10);
    force_before = force_error, jacobian_before = jacobian_error;
  }
  CHECK(force_before < 1e-8);
  CHECK(jacobian_before < 1e-8);
}

TEST_CASE("with a second phase the positive Jacobian stays positive semidefinite") {
  Sheet s = make_sheet(orthotropic());
  Points x = deformed(s.mesh, 7);
  x.col(0) *= 0.7;
  LimitPhase phase = phase_of(s, exceeded());
  phase.enter({}, x, 0, s.mesh.n_vertices());
  s.membrane.set_phase(phase.table(), phase.entered());
  BlockMatrix k = pattern(s.mesh);
  s.membrane.set_jacobian({}, x, {JacobianKind::Positive, {1.0, 0.0}}, 0, s.mesh.n_vertices(), k);
  const Eigen::VectorXd eigenvalues = test::eigenvalues(dense(k));
  CHECK(eigenvalues.minCoeff() > -1e-12 * eigenvalues.maxCoeff());
}

// Weft is limited to 10 %. The second phase begins at a strain of 9 %, the third at 9.5 % and the
// fourth at 10.5 %. In these phases, the added stiffness is 300, 3000 and 120,000 times the
// modulus.
TEST_CASE(
    "near its limit a strip enters three stiff phases in turn, and below these it is as soft as "
    "without a limit") {
  Sheet s = isotropic_sheet();
  LimitPhase phase = phase_of(s, weft_limit());
  for (const double strain : {0.05, 0.089, 0.093, 0.1, 0.104, 0.12}) {
    const Points x = stretched(s.mesh, strain);
    s.membrane.set_phase(nullptr, nullptr);
    const double elastic = tension(s, x);
    phase.enter({}, x, 0, s.mesh.n_vertices());
    s.membrane.set_phase(phase.table(), phase.entered());
    const double more = (tension(s, x) - elastic) / 0.2;  // [N/m], for a width of 0.2 m
    // The added first Piola-Kirchhoff stress is the stretch times the added second Piola-Kirchhoff
    // stress S. Here S is the product of 300, the modulus, the stretch and `beyond`.
    const double beyond = std::max(0.0, strain - 0.09) + 9.0 * std::max(0.0, strain - 0.095) +
                          390.0 * std::max(0.0, strain - 0.105);
    const double expected = 300 * 300.0 * (1 + strain) * (1 + strain) * beyond;
    CHECK(more == Approx(expected).epsilon(1e-9).margin(1e-9));
  }
}

TEST_CASE("a slow recovery adds viscosity far beyond a limit, but changes no stress at the start") {
  Sheet s = isotropic_sheet();
  LimitPhase phase = phase_of(s, weft_limit());
  const auto tensions = [&](double strain, double recovery) {
    phase.enter({}, stretched(s.mesh, strain), 0, s.mesh.n_vertices(), nullptr, recovery);
    s.membrane.set_phase(phase.table(), phase.entered());
    const double at_start = tension(s, stretched(s.mesh, strain));
    const double more = tension(s, stretched(s.mesh, strain + 1e-6)) - at_start;
    return std::pair(at_start, more);
  };
  // Within the third phase, `recovery` has no effect.
  CHECK(tensions(0.104, 0.1) == tensions(0.104, 1.0));
  const auto [force, slope] = tensions(0.3, 1.0);
  const auto [same_force, steeper_slope] = tensions(0.3, 0.1);
  CHECK(same_force == Approx(force).epsilon(1e-12));
  // The ratio of the slopes is below 1.0 / 0.1 = 10, because each slope also contains a part from
  // the stress, which does not depend on `recovery`.
  CHECK(steeper_slope > 5.0 * slope);
}

TEST_CASE("a yielding strip has a bounded stress in the mode that exceeds its limit most") {
  ClothMaterial material;
  material.weft_stiffness = 300, material.warp_stiffness = 300, material.shear_stiffness = 150,
  material.poisson = 0.0;
  Sheet s = make_sheet(material);
  StrainLimit limit;
  limit.weft = limit.warp = 0.1;
  LimitPhase phase = phase_of(s, limit);
  const std::vector<std::uint8_t> yields(s.mesh.n_vertices(), 1);
  // Returns the tension along weft [N] that the phases add at the strains `weft` and `warp`.
  const auto added = [&](double weft, double warp, const std::uint8_t* yielding) {
    Points x = stretched(s.mesh, weft);
    x.col(1) *= 1.0 + warp;
    s.membrane.set_phase(nullptr, nullptr);
    const double elastic = tension(s, x);
    phase.enter({}, x, 0, s.mesh.n_vertices(), yielding);
    s.membrane.set_phase(phase.table(), phase.entered());
    return tension(s, x) - elastic;
  };
  // At a strain of 0.0905, the stress is below its bound.
  CHECK(added(0.0905, 0.0, yields.data()) == added(0.0905, 0.0, nullptr));
  for (const double strain : {0.095, 0.12, 0.2}) {
    // `beyond` is the bound on the second Piola-Kirchhoff stress, divided by the stretch and by 300
    // times the modulus. It is 0.2 times the strain above 0.09, where the second phase begins, plus
    // 0.02 times 0.105. Without yielding, the stress at the start of the fourth phase, divided in
    // the same way, is 0.105: 10.5 times the margin of 0.01. `expected` contains the width, 0.2 m.
    const double beyond = 0.02 * 10.5 * 0.01 + 0.2 * (strain - 0.09);
    const double expected = 0.2 * 300 * 300.0 * (1 + strain) * (1 + strain) * beyond;
    CHECK(added(strain, 0.0, yields.data()) == Approx(expected).epsilon(1e-9));
    // Warp is farther beyond the start of its second phase than weft, so weft does not yield.
    CHECK(added(strain, strain + 0.01, yields.data()) ==
          Approx(added(strain, strain + 0.01, nullptr)).epsilon(1e-12));
  }
}

TEST_CASE("rotating the cloth does not change its phases") {
  Sheet s = make_sheet(orthotropic());
  const Points x = deformed(s.mesh, 3);
  const Mat3 turn = Eigen::AngleAxisd(1.1, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  const Points turned = x * turn.transpose();
  LimitPhase phase = phase_of(s, exceeded());
  phase.enter({}, x, 0, s.mesh.n_vertices());
  s.membrane.set_phase(phase.table(), phase.entered());
  const Points expected = force_of(s.membrane, x) * turn.transpose();
  phase.enter({}, turned, 0, s.mesh.n_vertices());
  CHECK((force_of(s.membrane, turned) - expected).norm() < 1e-9 * expected.norm());
}
