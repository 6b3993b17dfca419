// Tests of local expansions of the fields of magnets with many faces or cells, compared with
// exact sums.
#include <functional>
#include <random>

#include <catch2/catch.hpp>

#include "core/base/error.h"
#include "core/magnetics/fast_sums/expanded_mesh.h"
#include "core/magnetics/forces/cells.h"
#include "core/magnetics/sources/body.h"
#include "core/mesh/triangle_mesh.h"

using namespace loomstone;

namespace {

// Torus with radii of 40 mm and 15 mm and 3,200 faces.
std::shared_ptr<const MeshMagnet> ring() {
  constexpr Index around = 80, sides = 20;
  Points x(around * sides, 3);
  Triangles t(2 * around * sides, 3);
  for (Index i = 0; i < around; ++i) {
    for (Index k = 0; k < sides; ++k) {
      const double a = 2.0 * 3.141592653589793 * i / around,
                   b = 2.0 * 3.141592653589793 * k / sides, r = 0.04 + 0.015 * std::cos(b);
      x.row(i * sides + k) << r * std::cos(a), r * std::sin(a), 0.015 * std::sin(b);
      const Index corner[4] = {i * sides + k, (i + 1) % around * sides + k,
                               (i + 1) % around * sides + (k + 1) % sides,
                               i * sides + (k + 1) % sides};
      t.row(2 * (i * sides + k)) << corner[0], corner[1], corner[2];
      t.row(2 * (i * sides + k) + 1) << corner[0], corner[2], corner[3];
    }
  }
  return std::make_shared<MeshMagnet>(TriangleMesh(x, t), Vec3(0.3, -0.1, 0.6));
}

// Random points at the given distance from the surface of the torus, inside or outside.
Points beside(double distance, bool inside) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> angle(0.0, 2.0 * 3.141592653589793);
  Points x(300, 3);
  for (Index i = 0; i < 300; ++i) {
    const double a = angle(random), b = angle(random),
                 tube = 0.015 + (inside ? -distance : distance), r = 0.04 + tube * std::cos(b);
    x.row(i) << r * std::cos(a), r * std::sin(a), tube * std::sin(b);
  }
  return x;
}

void check_expansion(const SourcePtr& exact, const std::function<SourcePtr(double)>& expanded_to) {
  for (const double tolerance : {1e-2, 3e-4, 3e-5, 3e-7}) {
    const SourcePtr expanded = expanded_to(tolerance);
    for (const double distance : {0.0005, 0.002, 0.005, 0.02, 0.1, 0.3}) {
      for (const bool inside : {false, true}) {
        if (inside && distance > 0.005) continue;
        const Points x = beside(distance, inside);
        const FieldAndGradient a = magnetic_field_and_gradient(Team{}, {exact, {}}, x);
        const FieldAndGradient b = magnetic_field_and_gradient(Team{}, {expanded, {}}, x);
        INFO("tolerance " << tolerance << ", distance " << distance << ", inside " << inside);
        INFO("field " << (a.field - b.field).rowwise().norm().maxCoeff() /
                             a.field.rowwise().norm().maxCoeff()
                      << ", gradient "
                      << (a.gradient - b.gradient).rowwise().norm().maxCoeff() /
                             a.gradient.rowwise().norm().maxCoeff());
        CHECK((a.field - b.field).rowwise().norm().maxCoeff() <
              tolerance * a.field.rowwise().norm().maxCoeff());
        CHECK((a.gradient - b.gradient).rowwise().norm().maxCoeff() <
              tolerance * a.gradient.rowwise().norm().maxCoeff());
      }
    }
  }
}

}  // namespace

TEST_CASE("expanded fields and gradients are those of all faces within the tolerance") {
  const std::shared_ptr<const MeshMagnet> exact = ring();
  check_expansion(
      exact, [&](double tolerance) { return std::make_shared<ExpandedMesh>(exact, tolerance); });
}

TEST_CASE("expanded fields and gradients are those of all cells within the tolerance") {
  for (const double density : {1e6, 1e7}) {
    const auto exact = std::make_shared<CellMagnet>(*ring(), density, 3.0);
    INFO("leaves " << exact->dipoles()->positions().rows());
    check_expansion(exact, [&](double tolerance) {
      return std::make_shared<CellMagnet>(exact->expanded(tolerance));
    });
  }
}

TEST_CASE("the value at a point does not depend on the other points") {
  const CellMagnet cells(*ring(), 1e7, 3.0);
  const SourcePtr sources[] = {std::make_shared<ExpandedMesh>(ring(), 1e-4),
                               std::make_shared<CellMagnet>(cells.expanded(1e-3))};
  for (const SourcePtr& expanded : sources) {
    Points x = beside(0.004, false);
    x.bottomRows(40) *= 5.0;  // most of them outside the octree
    const FieldAndGradient all = magnetic_field_and_gradient(Team{2}, {expanded, {}}, x);
    for (Index i = 0; i < 300; i += 37) {
      const FieldAndGradient one = magnetic_field_and_gradient(Team{}, {expanded, {}}, x.row(i));
      CHECK(one.field.row(0) == all.field.row(i));
      CHECK(one.gradient.row(0) == all.gradient.row(i));
    }
    CHECK(magnetic_field(Team{}, {{expanded, {}}}, x, "B") == all.field);
    CHECK(magnetic_gradient(Team{}, {{expanded, {}}}, x) == all.gradient);
  }
}

TEST_CASE(
    "expanding the field of cells changes neither their fronts nor their moment nor the forces "
    "between them") {
  const CellMagnet exact(*ring(), 5e5, 3.0);
  const MagneticBody a{std::make_shared<CellMagnet>(exact), {}},
      b{std::make_shared<CellMagnet>(exact.expanded(1e-2)), {}};
  const MagneticBody other{std::make_shared<CellMagnet>(*ring(), 5e5, 3.0),
                           {Vec3(0.0, 0.02, 0.05), Vec4(1, 0, 0, 0)}};
  CHECK(cell_front(a, other).positions == cell_front(b, other).positions);
  CHECK(magnetic_wrench(a, other, 1e-4).force == magnetic_wrench(b, other, 1e-4).force);
  CHECK(a.source->moment() == b.source->moment());
}

TEST_CASE("a tolerance that expansions cannot reach, or of more than a tenth, is refused") {
  CHECK_THROWS_AS(ExpandedMesh(ring(), 1e-12), InvalidInput);
  CHECK_THROWS_AS(ExpandedMesh(ring(), 0.2), InvalidInput);
  CHECK_NOTHROW(ExpandedMesh(ring(), 0.1));
}
