// Tests of the lumped mid-edge stiffness, which semi-implicit steps can use. It is a sparse upper
// bound of half the Gauss-Newton stiffness.
#include <catch2/catch.hpp>
#include <random>

#include "core/cloth/bending/bending.h"
#include "core/mesh/generators.h"
#include "tests/support/decompositions.h"

using namespace loomstone;

namespace {

BendingSetup setup_of(const TriangleMesh& mesh, bool lumped) {
  BendingSetup setup;
  setup.rest_positions = mesh.vertices();
  setup.triangles = mesh.triangles();
  setup.corners = rest_corners(mesh, true, "mesh");
  Mat3 d;
  d << 2e-5, 3e-6, 0, 3e-6, 8e-6, 0, 0, 0, 4e-6;
  setup.rigidity.assign(mesh.n_triangles(), d);
  setup.damping.assign(mesh.n_triangles(), 0.0);
  setup.prescribed.assign(mesh.n_vertices(), 0);
  setup.lumped_stiffness = lumped;
  return setup;
}

struct Assembled {
  Eigen::MatrixXd dense;
  Index n_blocks;
};

Assembled assemble(const Bending& bending, const Points& x) {
  const Index n = static_cast<Index>(x.rows());
  BlockMatrix k(n, bending.couplings());
  bending.add_stiffness({}, x, {1.0, 0.0}, 0, n, k);
  Assembled out{Eigen::MatrixXd::Zero(3 * n, 3 * n), k.n_blocks()};
  for (Index i = 0; i < n; ++i)
    for (Index p = k.row_start()[i]; p < k.row_start()[i + 1]; ++p)
      out.dense.block<3, 3>(3 * i, 3 * k.columns()[p]) = k.block_map(p);
  return out;
}

}  // namespace

TEST_CASE(
    "the lumped stiffness is at least half of the full one in every folded shape, with a third of "
    "its blocks") {
  const TriangleMesh mesh = jittered_grid(0.2, 0.2, 8, 8, 0.24, 11);
  const auto whole = make_midedge_bending(setup_of(mesh, false)),
             lumped = make_midedge_bending(setup_of(mesh, true));
  std::mt19937 generator(5);
  std::uniform_real_distribution<double> uniform(-0.004, 0.004);
  for (int shape = 0; shape < 3; ++shape) {
    Points x = mesh.vertices();
    for (Index i = 0; i < x.size(); ++i) x.data()[i] += shape * uniform(generator);
    const Assembled k = assemble(*whole, x), bound = assemble(*lumped, x);
    const Eigen::VectorXd difference = test::eigenvalues(bound.dense - 0.5 * k.dense);
    // The tolerance allows for rounding errors, which are proportional to the norm of k.
    CHECK(difference.minCoeff() > -1e-12 * k.dense.norm());
    CHECK(3 * bound.n_blocks < 1.3 * k.n_blocks);
  }
}

TEST_CASE("lumping changes neither energy nor force nor the largest eigenvalue") {
  const TriangleMesh mesh = jittered_grid(0.2, 0.2, 8, 8, 0.24, 11);
  const auto whole = make_midedge_bending(setup_of(mesh, false)),
             lumped = make_midedge_bending(setup_of(mesh, true));
  Points x = mesh.vertices();
  for (Index i = 0; i < x.rows(); ++i) x(i, 2) = 0.01 * std::sin(30 * x(i, 0) + 20 * x(i, 1));
  const Points v = Points::Zero(x.rows(), 3);
  Points a = v, b = v;
  whole->add_forces({}, x, v, 0, static_cast<Index>(x.rows()), a);
  lumped->add_forces({}, x, v, 0, static_cast<Index>(x.rows()), b);
  CHECK(a == b);
  CHECK(whole->energy({}, x) == lumped->energy({}, x));
  const Vector mass = Vector::Constant(x.rows(), 1e-4);
  CHECK(whole->largest_eigenvalue(mass) == lumped->largest_eigenvalue(mass));
}
