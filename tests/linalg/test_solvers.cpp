#include <catch2/catch.hpp>

#include <Eigen/Cholesky>
#include <cstring>

#include "core/base/same_bits.h"
#include "core/linalg/aggregates.h"
#include "core/linalg/coupling_matrix.h"
#include "tests/linalg/random_system.h"

using namespace loomstone;
using testing::random_system;
using testing::RandomSystem;
using testing::stiffen;

namespace {

Points solved(const RandomSystem& system, const LinearOptions& options, int threads = 1,
              LinearReport* report = nullptr) {
  Points x = system.x;
  const LinearReport got =
      make_linear_solver(options)->solve(Team{threads}, system.view(), system.b, x);
  if (report) *report = got;
  return x;
}

// Returns the solution by dense factorisation, with identity rows and columns for fixed rows.
Points dense_solution(const RandomSystem& system) {
  Eigen::MatrixXd a = testing::dense_matrix(system.view());
  Points x = system.x;
  Vector prescribed = Vector::Zero(x.size());
  for (Index row = 0; row < x.rows(); ++row)
    if (system.fixed[row]) prescribed.segment<3>(3 * row) = x.row(row).transpose();
  Vector right = Eigen::Map<const Vector>(system.b.data(), system.b.size()) - a * prescribed;
  for (Index row = 0; row < x.rows(); ++row) {
    if (!system.fixed[row]) continue;
    a.middleRows<3>(3 * row).setZero();
    a.middleCols<3>(3 * row).setZero();
    a.block<3, 3>(3 * row, 3 * row).setIdentity();
    right.segment<3>(3 * row).setZero();
  }
  const Vector solution = a.llt().solve(right) + prescribed;
  return Eigen::Map<const Points>(solution.data(), x.rows(), 3);
}

}  // namespace

TEST_CASE("every method solves the system with terms, bodies and fixed rows") {
  const RandomSystem system = random_system(20, 2, 60);
  const Points expected = dense_solution(system);
  for (const LinearMethod method : {LinearMethod::Pcg, LinearMethod::BlockJacobi,
                                    LinearMethod::GaussSeidel, LinearMethod::Direct}) {
    INFO(name_of(method));
    LinearReport report;
    const Points x = solved(system, {method, 1e-12, 2000}, 1, &report);
    // The condition number of the free rows is below 100, so a relative residual of 1e-12 means a
    // relative error of x below 1e-10.
    CHECK((x - expected).norm() < 1e-10 * expected.norm());
    CHECK(report.converged);
    CHECK(report.iterations >= 1);
    CHECK(report.residual <= (method == LinearMethod::Direct ? 1e-13 : 1e-12));
  }
}

TEST_CASE("fixed rows keep every bit") {
  const RandomSystem system = random_system(20, 2, 60);
  for (const LinearMethod method : {LinearMethod::Pcg, LinearMethod::BlockJacobi,
                                    LinearMethod::GaussSeidel, LinearMethod::Direct}) {
    INFO(name_of(method));
    const Points x = solved(system, {method, 1e-6, 2000});
    for (Index row = 0; row < x.rows(); ++row)
      if (system.fixed[row])
        CHECK(std::memcmp(&x(row, 0), &system.x(row, 0), 3 * sizeof(double)) == 0);
  }
}

TEST_CASE("any number of threads gives the same bits") {
  const RandomSystem large = random_system(60, 3, 700),  // 29 blocks of rows, 6 tasks of terms
      small = random_system(30, 3, 350);  // 8 blocks, 3 tasks; small enough for Direct
  for (const LinearMethod method : {LinearMethod::Pcg, LinearMethod::BlockJacobi,
                                    LinearMethod::GaussSeidel, LinearMethod::Direct}) {
    INFO(name_of(method));
    const RandomSystem& system = method == LinearMethod::Direct ? small : large;
    const Points one = solved(system, {method, 1e-5, 2000}, 1);
    for (const int threads : {2, 3, 7})
      CHECK(same_bits(solved(system, {method, 1e-5, 2000}, threads), one));
  }
}

TEST_CASE("a solver used before gives the same bits as a new one") {
  const RandomSystem other = random_system(23, 1, 11), system = random_system(20, 2, 60);
  for (const LinearMethod method : {LinearMethod::Pcg, LinearMethod::BlockJacobi,
                                    LinearMethod::GaussSeidel, LinearMethod::Direct}) {
    INFO(name_of(method));
    const auto solver = make_linear_solver({method, 1e-5, 2000});
    SolveMemory memory;
    const auto solve = [&](const RandomSystem& given, Points& x) {
      solver->solve(Team{1}, given.view(), given.b, x, memory, Unchanged::Nothing);
    };
    Points first = other.x, again = system.x, fewer = system.x;
    solve(other, first);
    solve(system, again);
    CHECK(same_bits(again, solved(system, {method, 1e-5, 2000})));
    // `changed` has the matrix of `system` but fewer terms, so the joint pattern of matrix and
    // terms differs. The solver must notice this.
    RandomSystem changed = random_system(20, 2, 60);
    changed.terms.resize(17);
    solve(changed, fewer);
    CHECK(same_bits(fewer, solved(changed, {method, 1e-5, 2000})));
  }
}

TEST_CASE("a good guess saves iterations and a bad one is discarded") {
  RandomSystem system = random_system(20, 2, 60);
  for (const LinearMethod method :
       {LinearMethod::Pcg, LinearMethod::BlockJacobi, LinearMethod::GaussSeidel}) {
    INFO(name_of(method));
    const LinearOptions options{method, 1e-6, 2000};
    LinearReport from_zero, from_good, from_bad;
    const Points x = solved(system, options, 1, &from_zero);
    RandomSystem good = random_system(20, 2, 60), bad = random_system(20, 2, 60);
    for (Index row = 0; row < x.rows(); ++row)
      if (!system.fixed[row]) good.x.row(row) = x.row(row), bad.x.row(row) = -3.0 * x.row(row);
    solved(good, options, 1, &from_good);
    const Points from_bad_x = solved(bad, options, 1, &from_bad);
    CHECK(from_good.iterations == 0);
    CHECK(from_bad.iterations == from_zero.iterations);
    CHECK(same_bits(from_bad_x, x));
  }
}

TEST_CASE(
    "the preconditioned residual reaches the tolerance, and an unconverged solve is reported") {
  const RandomSystem system = random_system(30, 0, 0);
  LinearReport loose, tight, stopped;
  solved(system, {LinearMethod::Pcg, 1e-2, 2000}, 1, &loose);
  solved(system, {LinearMethod::Pcg, 1e-8, 2000}, 1, &tight);
  solved(system, {LinearMethod::Pcg, 1e-8, 3}, 1, &stopped);
  CHECK(loose.residual <= 1e-2);
  CHECK(tight.residual <= 1e-8);
  CHECK(loose.iterations < tight.iterations);
  CHECK_FALSE(stopped.converged);
  CHECK(stopped.iterations == 3);
  CHECK(stopped.residual > 1e-8);
}

TEST_CASE("rounding the stiffness to single precision does not change the mass of a translation") {
  RandomSystem system = random_system(20, 0, 0);
  stiffen(system, 1e6);
  const Index n = system.matrix.n_rows();
  SlicedEllpack slices;
  const Index n_rows = system.view().layout->n_rows();
  slices.set_pattern(system.view().matrix, {n_rows, 0, n_rows});
  CouplingMatrix<float> single;
  single.resize(slices);
  single.set_slices(system.view().matrix, system.view().body_blocks, slices, 0, slices.n_slices());
  std::vector<float> x(4 * (n + 1), 0.0f), y(24 * slices.n_slices());
  for (Index row = 0; row < n; ++row)
    x[4 * row] = 1.0f, x[4 * row + 1] = -2.0f, x[4 * row + 2] = 0.5f;
  single.multiply(slices, 0, slices.n_slices(), x.data(), y.data());
  // All rows of x are equal, so the stiffness adds nothing to y. All masses are 1, so y equals x.
  // The tolerance covers rounding, in double precision, of sums whose terms are about 1e7. In
  // single precision, the error would be 1.
  for (Index row = 0; row < n; ++row)
    for (int d = 0; d < 3; ++d)
      CHECK(std::abs(y[24 * (slices.place[row] / 8) + 8 * d + slices.place[row] % 8] -
                     x[4 * row + d]) < 1e-6);
}

TEST_CASE("a product by rows is the product by slices") {
  const RandomSystem system = random_system(20, 0, 0);
  const Index n = system.matrix.n_rows();
  SlicedEllpack slices;
  slices.set_pattern(&system.matrix, {n, 0, n});
  CouplingMatrix<float> matrix;
  matrix.resize(slices);
  matrix.set_slices(&system.matrix, nullptr, slices, 0, slices.n_slices());
  std::vector<float> x(4 * (n + 1), 0.0f), y(24 * slices.n_slices()), by_rows(x.size(), 1.0f);
  for (Index row = 0; row < n; ++row)
    for (int d = 0; d < 3; ++d) x[4 * row + d] = static_cast<float>(system.b(row, d));
  matrix.multiply(slices, 0, slices.n_slices(), x.data(), y.data());
  matrix.multiply_to_rows(slices, 0, slices.n_slices(), x.data(), by_rows.data());
  for (Index row = 0; row < n; ++row) {
    for (int d = 0; d < 3; ++d)
      CHECK(by_rows[4 * row + d] ==
            y[24 * (slices.place[row] / 8) + 8 * d + slices.place[row] % 8]);
    CHECK(by_rows[4 * row + 3] == 0.0f);
  }
}

TEST_CASE("a system too stiff for single precision is still solved") {
  RandomSystem system = random_system(20, 0, 0);
  stiffen(system, 1e9);
  std::fill(system.fixed.begin(), system.fixed.end(), 0);
  system.x.setZero();
  for (const LinearMethod method :
       {LinearMethod::Pcg, LinearMethod::BlockJacobi, LinearMethod::GaussSeidel}) {
    INFO(name_of(method));
    LinearReport report;
    const Points x = solved(system, {method, 1e-6, 20000}, 1, &report);
    CHECK(report.converged);
    // The tolerance of 1e-6 applies to a norm with weights close to the inverse diagonal. The
    // diagonal varies tenfold, so the unweighted residual may be larger.
    const Eigen::MatrixXd a = testing::dense_matrix(system.view());
    const Vector b = Eigen::Map<const Vector>(system.b.data(), system.b.size());
    const Vector r = b - a * Eigen::Map<const Vector>(x.data(), x.size());
    CHECK(r.norm() < 1e-5 * b.norm());
  }
}

TEST_CASE("symmetric Gauss-Seidel needs fewer iterations than block-Jacobi") {
  const RandomSystem system = random_system(40, 2, 100);
  LinearReport jacobi, gauss_seidel;
  solved(system, {LinearMethod::BlockJacobi, 1e-6, 2000}, 1, &jacobi);
  solved(system, {LinearMethod::GaussSeidel, 1e-6, 2000}, 1, &gauss_seidel);
  CHECK(gauss_seidel.iterations < 0.7 * jacobi.iterations);
}

namespace {

// A grid of tiles x tiles patches of 11 x 11 rows. Rows are ordered patch by patch, like the
// vertices of a cloth model. Coarse levels are effective here, because all springs have the same
// stiffness, all masses are 1, and the load varies slowly.
RandomSystem smooth_system(Index tiles, double stiffness) {
  const Index side = 11 * tiles;
  const auto row_of = [&](Index r, Index c) {
    return 121 * (r / 11 * tiles + c / 11) + 11 * (r % 11) + c % 11;
  };
  RandomSystem system = random_system(side, 0, 0);
  std::vector<std::pair<Index, Index>> couplings;
  for (Index r = 0; r < side; ++r)
    for (Index c = 0; c < side; ++c) {
      if (c + 1 < side) couplings.emplace_back(row_of(r, c), row_of(r, c + 1));
      if (r + 1 < side) couplings.emplace_back(row_of(r, c), row_of(r + 1, c));
      system.b.row(row_of(r, c)).setConstant(std::sin(3.0 * c / side));
    }
  BlockMatrix& a = system.matrix;
  a = BlockMatrix(side * side, couplings);
  for (Index row = 0; row < a.n_rows(); ++row)
    for (Index k = a.row_start()[row]; k < a.row_start()[row + 1]; ++k) {
      if (k != a.diagonal()[row]) a.block_map(k) = -stiffness * Mat3::Identity();
      a.block_map(a.diagonal()[row]) +=
          (k == a.diagonal()[row] ? 1.0 : stiffness) * Mat3::Identity();
    }
  std::fill(system.fixed.begin(), system.fixed.end(), 0);
  system.x.setZero();
  return system;
}

}  // namespace

TEST_CASE(
    "coarse levels save iterations if distant rows are coupled, and more so on larger meshes") {
  for (const Index tiles : {4, 11}) {
    const RandomSystem system = smooth_system(tiles, 1e4);
    LinearReport levels, jacobi;
    const Points x = solved(system, {LinearMethod::Pcg, 1e-6, 4000}, 1, &levels);
    const Points expected = solved(system, {LinearMethod::BlockJacobi, 1e-10, 4000}, 1, &jacobi);
    // The relative error may exceed the relative residual, because the smallest eigenvalue is only
    // 2.5e-5 times the diagonal entries.
    CHECK((x - expected).norm() < 1e-3 * expected.norm());
    solved(system, {LinearMethod::BlockJacobi, 1e-6, 4000}, 1, &jacobi);
    CHECK(levels.iterations < (tiles == 4 ? 0.6 : 0.35) * jacobi.iterations);
  }
}

TEST_CASE("with coarse levels, stiff terms between layers cost few iterations") {
  // The grid is folded in the middle, so that the points of one half lie on points of the other.
  // Points that lie on each other have the same load. In the second solve, stiff terms tie them.
  const Index tiles = 8, side = 11 * tiles;
  const auto row_of = [&](Index r, Index c) {
    return 121 * (r / 11 * tiles + c / 11) + 11 * (r % 11) + c % 11;
  };
  RandomSystem system = smooth_system(tiles, 1e4);
  LinearReport apart, tied;
  for (Index r = 0; r < side; ++r)
    for (Index c = 0; c < side / 2; ++c) {
      const double load = std::sin(3.0 * r / side) + c / static_cast<double>(side);
      system.b.row(row_of(r, c)).setConstant(load),
          system.b.row(row_of(r, side - 1 - c)).setConstant(load);
    }
  solved(system, {LinearMethod::Pcg, 1e-6, 4000}, 1, &apart);
  for (Index r = 0; r < side; ++r)
    for (Index c = 0; c < side / 2; ++c) {
      ExtraTerm term;
      const Index a = row_of(r, c), b = row_of(r, side - 1 - c);
      term.entries[0] = {std::min(a, b), false, 1.0},
      term.entries[1] = {std::max(a, b), false, -1.0}, term.n_entries = 2;
      term.hessian = 1e6 * Mat3::Identity();
      system.terms.push_back(term);
    }
  solved(system, {LinearMethod::Pcg, 1e-6, 4000}, 1, &tied);
  // If the coarse levels lacked the couplings of terms, the solve would need many more iterations.
  CHECK(tied.iterations < 4 * apart.iterations);
}

TEST_CASE("a solve with other terms on the same matrix agrees with a first solve") {
  const RandomSystem system = random_system(20, 2, 60);
  RandomSystem other = random_system(20, 2, 60);
  other.terms.resize(41);
  const Points exact = solved(other, {LinearMethod::Direct, 1e-10, 2000});
  for (const LinearMethod method : {LinearMethod::Pcg, LinearMethod::BlockJacobi,
                                    LinearMethod::GaussSeidel, LinearMethod::Direct}) {
    INFO(name_of(method));
    const auto solver = make_linear_solver({method, 1e-10, 2000});
    Points first = system.x, second = system.x;
    SolveMemory memory;
    solver->solve(Team{1}, system.view(), system.b, first, memory, Unchanged::Nothing);
    LinearSystem again = system.view();
    again.terms = &other.terms;
    CHECK(solver->solve(Team{1}, again, system.b, second, memory, Unchanged::Matrix).converged);
    // Every solver agrees with the direct solution. The tolerance of 1e-10 applies to the residual,
    // so the error may be larger. Solvers that keep no preconditioner from the first solve also
    // agree bitwise with a new solver.
    CHECK((second - exact).norm() < 1e-8 * exact.norm());
    if (method == LinearMethod::GaussSeidel || method == LinearMethod::Direct)
      CHECK(same_bits(second, solved(other, {method, 1e-10, 2000})));
  }
}

TEST_CASE("a solve can continue from a rough one") {
  const RandomSystem system = random_system(30, 2, 100);
  RandomSystem other = random_system(30, 2, 100);
  for (ExtraTerm& term : other.terms) term.hessian *= 0.7;
  const Points exact_other = solved(other, {LinearMethod::Direct, 1e-10, 2000});
  for (const LinearMethod method :
       {LinearMethod::Pcg, LinearMethod::BlockJacobi, LinearMethod::GaussSeidel}) {
    INFO(name_of(method));
    SolveMemory memory;
    const auto rough_solve = [&](LinearSolver& solver, int threads, Points& x) {
      LinearSystem rough = system.view();
      rough.tolerance = 1e-2;
      return solver.solve(Team{threads}, rough, system.b, x, memory, Unchanged::Nothing).iterations;
    };
    LinearSystem again = system.view();
    Points of_one_thread;
    for (const int threads : {1, 3}) {
      // With the same system, the second solve continues as if the first had not stopped.
      LinearReport whole;
      const Points at_once = solved(system, {method, 1e-4, 2000}, threads, &whole);
      auto solver = make_linear_solver({method, 1e-4, 2000});
      Points x = system.x;
      const int first = rough_solve(*solver, threads, x);
      again.terms = &system.terms;
      const LinearReport rest =
          solver->solve(Team{threads}, again, system.b, x, memory, Unchanged::System);
      CHECK((first > 0 && rest.iterations > 0));
      CHECK(first + rest.iterations == whole.iterations);
      CHECK(same_bits(x, at_once));

      // If the terms change after the first solve, the reported residual is that of the system with
      // the new terms, computed in double precision.
      solver = make_linear_solver({method, 1e-9, 2000});
      Points y = system.x;
      rough_solve(*solver, threads, y);
      again.terms = &other.terms;
      CHECK(solver->solve(Team{threads}, again, system.b, y, memory, Unchanged::Matrix).residual <=
            1e-9);
      CHECK((y - exact_other).norm() < 1e-7 * exact_other.norm());
      if (threads == 1) of_one_thread = y;
      CHECK(same_bits(y, of_one_thread));
    }
  }
}

TEST_CASE("a system can set a looser tolerance than the solver's") {
  const RandomSystem system = random_system(30, 0, 0);
  LinearSystem rough = system.view();
  rough.tolerance = 1e-2;
  Points x = system.x;
  const LinearReport report =
      make_linear_solver({LinearMethod::Pcg, 1e-8, 2000})->solve(Team{1}, rough, system.b, x);
  CHECK(report.residual <= 1e-2);
  CHECK(report.residual > 1e-6);
}

TEST_CASE("residuals are relative to the least change where the right-hand side is smaller") {
  const RandomSystem system = random_system(20, 2, 60);
  const Points expected = dense_solution(system);
  const Vector masses = Vector::Ones(400);
  LinearSystem view = system.view();
  const auto solver = make_linear_solver({LinearMethod::Pcg, 1e-6, 2000});
  const auto solve = [&](double scale, Points& x) {
    view.masses = &masses;
    view.least_change.setConstant(scale);
    x = system.x;
    return solver->solve(Team{1}, view, system.b, x);
  };
  Points exact, near, rough;
  const LinearReport usual = solve(0.0, exact);
  CHECK(solve(1e-3, near).iterations == usual.iterations);  // 1e-3 is too small to have an effect
  CHECK(same_bits(near, exact));
  const LinearReport loose = solve(1e6, rough);
  CHECK(loose.converged);
  CHECK(loose.residual <= 1e-6);
  CHECK(loose.iterations > 0);
  CHECK(loose.iterations < usual.iterations / 2);
  CHECK((rough - expected).norm() > 100.0 * (exact - expected).norm());
  CHECK(solve(1e10, rough).iterations == 0);
}

TEST_CASE("the norm of the least change is that of an equal right-hand side") {
  RandomSystem system = random_system(20, 0, 0);
  const Vec3 change(1.0, -2.0, 0.5);
  const Vector masses = Vector::LinSpaced(400, 1.0, 2.0);
  system.b = masses * change.transpose();
  for (Index row = 0; row < system.x.rows(); ++row)
    if (system.fixed[row] != 0) system.x.row(row).setZero();
  LinearSystem view = system.view();
  view.masses = &masses;
  const auto solver = make_linear_solver({LinearMethod::Pcg, 10.0, 2000});  // accepts x = 0
  const auto residual = [&](double scale) {
    view.least_change = scale * change;
    Points x = system.x;
    return solver->solve(Team{1}, view, system.b, x).residual;
  };
  CHECK(residual(0.0) == 1.0);
  CHECK(residual(0.999) == 1.0);
  CHECK(residual(2.0) == 0.5);
}

TEST_CASE("aggregates hold about a dozen connected rows of one block each") {
  const RandomSystem system = random_system(33, 0, 0);
  const Aggregates aggregates = grow_aggregates(system.matrix, *system.layout);
  const BlockMatrix& a = system.matrix;
  std::vector<std::vector<Index>> members(aggregates.count());
  for (Index row = 0; row < a.n_rows(); ++row) {
    const Index node = aggregates.of_row[row], block = row / rows_per_block;
    CHECK((node >= aggregates.block_start[block] && node < aggregates.block_start[block + 1]));
    members[node].push_back(row);
  }
  CHECK(aggregates.count() < a.n_rows() / 6);
  for (const std::vector<Index>& rows : members) {
    CHECK(rows.size() < 24);
    std::vector<Index> reached = {rows.front()};
    for (std::size_t next = 0; next < reached.size(); ++next)
      for (Index k = a.row_start()[reached[next]]; k < a.row_start()[reached[next] + 1]; ++k)
        if (const Index other = a.columns()[k];
            aggregates.of_row[other] == aggregates.of_row[rows.front()] &&
            std::find(reached.begin(), reached.end(), other) == reached.end())
          reached.push_back(other);
    CHECK(reached.size() == rows.size());
  }
}

TEST_CASE("checking the true residual during a solve costs no iterations") {
  const RandomSystem system = random_system(40, 2, 100);
  for (const LinearMethod method :
       {LinearMethod::Pcg, LinearMethod::BlockJacobi, LinearMethod::GaussSeidel}) {
    INFO(name_of(method));
    LinearReport coarse, fine;
    solved(system, {method, 1e-4, 2000}, 1, &coarse);
    solved(system, {method, 1e-8, 2000}, 1, &fine);  // several rounds of residual replacement
    // At a constant rate of convergence, twice as many digits need twice the iterations. If search
    // directions lost their conjugacy when the residual is replaced, the factor would be larger.
    CHECK(fine.iterations <= 2.3 * coarse.iterations);
  }
}

TEST_CASE("a zero right-hand side gives zero for any guess") {
  RandomSystem system = random_system(10, 1, 5);
  system.b.setZero();
  std::fill(system.fixed.begin(), system.fixed.end(), 0);
  system.x.setOnes();
  for (const LinearMethod method : {LinearMethod::Pcg, LinearMethod::BlockJacobi,
                                    LinearMethod::GaussSeidel, LinearMethod::Direct}) {
    INFO(name_of(method));
    CHECK(solved(system, {method, 1e-6, 2000}).isZero(0.0));
  }
}

TEST_CASE("a system with all rows fixed leaves x unchanged") {
  RandomSystem system = random_system(10, 1, 5);
  std::fill(system.fixed.begin(), system.fixed.end(), 1);
  for (const LinearMethod method : {LinearMethod::Pcg, LinearMethod::BlockJacobi,
                                    LinearMethod::GaussSeidel, LinearMethod::Direct}) {
    INFO(name_of(method));
    CHECK(same_bits(solved(system, {method, 1e-6, 2000}), system.x));
  }
}

TEST_CASE("the supernodal factorisation is used by name alone") {
  // By default, CHOLMOD would choose the supernodal factorisation for a system of this size (3,606
  // rows).
  const RandomSystem system = random_system(60, 3, 700);
  const Points direct = solved(system, {LinearMethod::Direct, 1e-10, 2000});
  try {
    const Points supernodal = solved(system, {LinearMethod::Supernodal, 1e-10, 2000});
    // The condition number is below 400, so rounding changes x by less than 1e-12 of its norm.
    CHECK((direct - supernodal).norm() < 1e-12 * direct.norm());
    CHECK_FALSE(same_bits(direct, supernodal));
  } catch (const Unsupported& error) {  // this CHOLMOD lacks its supernodal module
    CHECK_THAT(error.what(), Catch::Matchers::Contains("supernodal module") &&
                                 Catch::Matchers::Contains("use \"direct\""));
  }
}
