// Tests of bending compared with beam and plate theory. A clamp is at least two prescribed rows of
// vertices, with edges along the clamp line. The Poisson ratio is 0 unless stated otherwise.
#include <catch2/catch.hpp>

#include <cmath>

#include "core/mesh/generators.h"
#include "tests/cloth/bending/bending_support.h"

using namespace loomstone;
using namespace loomstone::test;

namespace {

// Cantilever of length 1 m.
struct Cantilever {
  std::string element, pattern;
  Index across;
  Mat3 rigidity;
  double angle = 0.0;  // angle from the axis of the cantilever (x) to weft [rad]
  double width = 0.2;
};

// Returns the tip deflection under a uniform load q, divided by the deflection q L^4 / (8 b) of
// beam theory for the flexural rigidity b.
double deflection_ratio(const Cantilever& c, double b) {
  const Strip strip = make_strip(c.pattern, 1.0, c.width, c.across);
  BendingSetup setup = flat_setup(strip.vertices, strip.triangles, c.rigidity, c.angle);
  setup.prescribed = strip.prescribed;
  return tip_deflection(strip, *make_bending(c.element, setup)) * 8.0 * b;
}

}  // namespace

TEST_CASE("a mid-edge cantilever sags as beam theory says, whatever the mesh and its direction") {
  const std::string pattern =
      GENERATE("alternating", "diagonal", "mirrored", "jittered", "along", "across");
  const Index across = GENERATE(4, 6, 10);
  CAPTURE(pattern, across);
  CHECK(deflection_ratio({"midedge", pattern, across, isotropic(1.0, 0.0)}, 1.0) ==
        Approx(1.0).epsilon(0.005));
}

TEST_CASE("a mid-edge cantilever sags as beam theory says on raw meshes with slivers") {
  const Index across = GENERATE(4, 6, 10);
  double least = M_PI, worst = 0.0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    double angle = 0.0;
    const Strip strip = random_strip(1.0, 0.2, across, seed, 0, &angle);
    // Meshes with a nearly degenerate triangle are skipped.
    if (angle < 1.0 * M_PI / 180) continue;
    BendingSetup setup = flat_setup(strip.vertices, strip.triangles, isotropic(1.0, 0.0));
    setup.prescribed = strip.prescribed;
    const auto bending = make_midedge_bending(setup);
    const double ratio = 8.0 * tip_deflection(strip, *bending);
    CAPTURE(across, seed, angle, bending->averaged_edges());
    CHECK(ratio == Approx(1.0).epsilon(0.01));
    least = std::min(least, angle), worst = std::max(worst, std::abs(ratio - 1.0));
  }
  CHECK(least < 3.0 * M_PI / 180);  // the meshes contain slivers
  UNSCOPED_INFO(across << " across: worst " << worst);
}

TEST_CASE(
    "the deflection of a simply supported plate converges with the square of the element's size") {
  const std::string pattern = GENERATE("alternating", "jittered", "diagonal");
  CAPTURE(pattern);
  // Deflection of the centre of a simply supported square plate for nu = 0.3, in units of
  // q a^4 / B, with the load q, the side a and the flexural rigidity B (Timoshenko and
  // Woinowsky-Krieger).
  const double exact = 0.0040624;
  std::vector<double> errors;
  for (const Index n : {6, 12, 24}) {
    const TriangleMesh mesh =
        grid_cells(1.0, 1.0, n, n, pattern == "diagonal" ? "diagonal" : "alternating");
    Points x = mesh.vertices();
    const Index centre = (n / 2) * (n + 1) + n / 2;
    std::vector<std::uint8_t> edge(mesh.n_vertices(), 0);
    const Points shift = noise(mesh.n_vertices(), pattern == "jittered" ? 0.25 / n : 0.0, 5);
    for (Index i = 0; i < mesh.n_vertices(); ++i) {
      const Index column = i % (n + 1), row = i / (n + 1);
      edge[i] = column == 0 || row == 0 || column == n || row == n;
      if (!edge[i] && i != centre) x.block<1, 2>(i, 0) += shift.block<1, 2>(i, 0);
    }
    BendingSetup setup = flat_setup(x, mesh.triangles(), isotropic(1.0, 0.3));
    setup.prescribed = edge;  // a single prescribed row is a simple support
    const Vector z = deflections(x, mesh.triangles(), edge, *make_midedge_bending(setup));
    errors.push_back(std::abs(z[centre] / exact - 1.0));
  }
  CAPTURE(errors);
  CHECK(std::log2(errors[0] / errors[1]) > 1.7);
  CHECK(std::log2(errors[1] / errors[2]) > 1.7);
  CHECK(errors[2] < 0.005);
}

TEST_CASE("an orthotropic strip sags by its compliance along the strip") {
  const std::string pattern = GENERATE("alternating", "diagonal", "jittered", "along");
  CAPTURE(pattern);
  Mat3 d = Mat3::Zero();
  d.diagonal() << 1.0, 9.0, 0.8;
  // Free edges carry no moment, so the flexural rigidity of the strip is the reciprocal of a
  // diagonal entry of D^-1: the first along weft, the second along warp.
  CHECK(deflection_ratio({"midedge", pattern, 8, d}, 1.0) == Approx(1.0).epsilon(0.02));
  CHECK(deflection_ratio({"midedge", pattern, 8, d, -M_PI / 2}, 9.0) == Approx(1.0).epsilon(0.02));
  d(0, 1) = d(1, 0) = 0.3;
  const Mat3 compliance = d.inverse();
  CHECK(deflection_ratio({"midedge", pattern, 8, d}, 1.0 / compliance(0, 0)) ==
        Approx(1.0).epsilon(0.02));
  CHECK(deflection_ratio({"midedge", pattern, 8, d, -M_PI / 2}, 1.0 / compliance(1, 1)) ==
        Approx(1.0).epsilon(0.02));
}

TEST_CASE("a strip cut on the bias sags by the rigidity that weft, warp and twist imply") {
  const std::string pattern = GENERATE("alternating", "diagonal", "jittered", "along");
  const double coupling = GENERATE(0.0, 0.3);
  CAPTURE(pattern, coupling);
  Mat3 d = Mat3::Zero();
  d.diagonal() << 1.0, 3.0, 0.8;
  d(0, 1) = d(1, 0) = coupling;
  const Mat3 s = d.inverse();
  // Moments across the strip and twisting moments vanish, so at 45 degrees the flexural rigidity B
  // of the strip follows from 1 / B = (S11 + S22 + 2 S12 + S33) / 4 with S = D^-1. The clamp
  // prevents twisting and thus stiffens the strip. A narrow strip (width 0.1, length 1) keeps this
  // effect small.
  const double compliance = 0.25 * (s(0, 0) + s(1, 1) + 2.0 * s(0, 1) + s(2, 2));
  CHECK(deflection_ratio({"midedge", pattern, 6, d, M_PI / 4, 0.1}, 1.0 / compliance) ==
        Approx(1.0).epsilon(0.02));
  CHECK(deflection_ratio({"midedge", pattern, 6, d, -M_PI / 4, 0.1}, 1.0 / compliance) ==
        Approx(1.0).epsilon(0.02));
}

TEST_CASE("the hinge's rigidity along the axes of a grid is within 25 percent of B") {
  const std::string pattern = GENERATE("alternating", "diagonal");
  const Index across = GENERATE(4, 8, 12);
  CAPTURE(pattern, across);
  CHECK(1.0 / deflection_ratio({"hinge", pattern, across, isotropic(1.0, 0.0)}, 1.0) ==
        Approx(1.0).epsilon(0.25));
}

TEST_CASE(
    "the hinge's rigidity in strips of smoothed irregular mesh is within 12 percent of B at 16 "
    "elements across, 18 at 6") {
  // Boundary edges have no hinge, so narrow strips are softer than the material, whose rigidity is
  // B. The smallest rigidity of four random strips is 0.833 B at 6 elements across, 0.871 B at 10
  // and 0.883 B at 16.
  const auto [across, bound] = GENERATE(table<Index, double>({{6, 0.18}, {10, 0.14}, {16, 0.12}}));
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const Strip strip = random_strip(1.0, 0.2, across, seed, 30);
    CAPTURE(across, seed);
    BendingSetup setup = flat_setup(strip.vertices, strip.triangles, isotropic(1.0, 0.0));
    setup.prescribed = strip.prescribed;
    CHECK(1.0 / (8.0 * tip_deflection(strip, *make_hinge_bending(setup))) ==
          Approx(1.0).epsilon(bound));
  }
}

TEST_CASE("the hinge's rigidity at 45 degrees to a grid differs from B by more than 20 percent") {
  // Measured rigidity of the strip, relative to that of the material: 2.04 if diagonals run along
  // the strip, and 0.75 if they run across it.
  for (const std::string pattern : {"along", "across"}) {
    const double ratio = 1.0 / deflection_ratio({"hinge", pattern, 8, isotropic(1.0, 0.0)}, 1.0);
    CHECK(std::isfinite(ratio));
    UNSCOPED_INFO(pattern << ": " << ratio);
    CHECK(std::abs(ratio - 1.0) > 0.2);
  }
}
