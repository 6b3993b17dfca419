#include <catch2/catch.hpp>

#include <limits>

#include "core/base/error.h"
#include "tests/linalg/random_system.h"

using namespace loomstone;
using Catch::Matchers::Contains;
using testing::random_system;
using testing::RandomSystem;

namespace {

void solve(const RandomSystem& system, LinearMethod method) {
  Points x = system.x;
  make_linear_solver({method, 1e-6, 2000})->solve(Team{1}, system.view(), system.b, x);
}

// Communicator that reports two ranks and fails the test at any collective call.
class PretendedRanks final : public Communicator {
 public:
  int rank() const override { return 0; }
  int size() const override { return 2; }
  void barrier() const override { FAIL("a collective call"); }
  std::int64_t maximum(std::int64_t value) const override {
    FAIL("a collective call");
    return value;
  }
  void broadcast(void*, std::size_t, int) const override { FAIL("a collective call"); }
  void start_gather(void*, const std::vector<std::size_t>&) const override {
    FAIL("a collective call");
  }
  void start_exchange(const std::vector<Message>&, const std::vector<Message>&) const override {
    FAIL("a collective call");
  }
  void start_add(BinnedSum*, int) const override { FAIL("a collective call"); }
  void finish() const override { FAIL("a collective call"); }
  void abort(int) const override { std::abort(); }
};

}  // namespace

TEST_CASE("unknown methods and invalid options are refused by name") {
  CHECK_THROWS_WITH(choice_named<LinearMethod>("jacobi", "linear_solver"),
                    Contains("pcg | block-jacobi | gauss-seidel | direct | supernodal") &&
                        Contains("got \"jacobi\""));
  CHECK_THROWS_AS(choice_named<LinearMethod>("jacobi", "linear_solver"), InvalidInput);
  CHECK_THROWS_WITH(make_linear_solver({LinearMethod::Pcg, 0.0, 10}),
                    Contains("tolerance must be > 0"));
  CHECK_THROWS_WITH(make_linear_solver({LinearMethod::Pcg, std::nan(""), 10}),
                    Contains("tolerance must be > 0"));
  CHECK_THROWS_WITH(make_linear_solver({LinearMethod::Pcg, 1e-4, 0}),
                    Contains("max_iterations must be >= 1, got 0"));
}

TEST_CASE("a right-hand side that is not finite is refused with its row") {
  for (const LinearMethod method : {LinearMethod::Pcg, LinearMethod::BlockJacobi,
                                    LinearMethod::GaussSeidel, LinearMethod::Direct}) {
    INFO(name_of(method));
    RandomSystem system = random_system(10, 1, 5);
    system.b(43, 1) = std::numeric_limits<double>::quiet_NaN();
    CHECK_THROWS_AS(solve(system, method), SolverFailure);
    CHECK_THROWS_WITH(solve(system, method), Contains("must be finite") && Contains("row 43"));
  }
}

TEST_CASE("a matrix that is not finite is refused") {
  for (const LinearMethod method : {LinearMethod::Pcg, LinearMethod::BlockJacobi,
                                    LinearMethod::GaussSeidel, LinearMethod::Direct}) {
    INFO(name_of(method));
    RandomSystem system = random_system(10, 0, 0);
    system.matrix.block_map(system.matrix.find(12, 13))(0, 1) =
        std::numeric_limits<double>::infinity();
    system.matrix.block_map(system.matrix.find(13, 12))(1, 0) =
        std::numeric_limits<double>::infinity();
    CHECK_THROWS_AS(solve(system, method), StepFailure);  // a shorter step may be finite
  }
}

TEST_CASE("a diagonal block that is not positive definite is refused with its row") {
  for (const LinearMethod method :
       {LinearMethod::Pcg, LinearMethod::BlockJacobi, LinearMethod::GaussSeidel}) {
    INFO(name_of(method));
    RandomSystem system = random_system(10, 0, 0);
    system.matrix.block_map(system.matrix.diagonal()[31])(2, 2) = -1.0;
    CHECK_THROWS_AS(solve(system, method), StepFailure);
    CHECK_THROWS_WITH(solve(system, method), Contains("positive definite") && Contains("row 31"));
  }
}

TEST_CASE("an indefinite matrix with good diagonal blocks is refused") {
  for (const LinearMethod method : {LinearMethod::Pcg, LinearMethod::BlockJacobi,
                                    LinearMethod::GaussSeidel, LinearMethod::Direct}) {
    INFO(name_of(method));
    RandomSystem system = random_system(10, 0, 0);
    for (const auto& [i, j] : {std::pair<Index, Index>{40, 41}, {41, 40}})
      system.matrix.block_map(system.matrix.find(i, j)) += 1e3 * Mat3::Identity();
    CHECK_THROWS_AS(solve(system, method), StepFailure);
    CHECK_THROWS_WITH(solve(system, method), Contains("must be positive definite"));
  }
}

TEST_CASE("arrays of wrong length are refused with both lengths") {
  RandomSystem system = random_system(10, 0, 0);
  system.b.resize(99, 3);
  CHECK_THROWS_AS(solve(system, LinearMethod::Pcg), InvalidInput);
  CHECK_THROWS_WITH(solve(system, LinearMethod::Pcg),
                    Contains("b must have one row for each of the 100 rows") && Contains("got 99"));
}

TEST_CASE("methods limited to one rank are refused before any communication") {
  for (const LinearMethod method : {LinearMethod::GaussSeidel, LinearMethod::Direct}) {
    INFO(name_of(method));
    RandomSystem system = random_system(20, 0, 0);
    system.layout = std::make_unique<RowLayout>(400, std::make_shared<PretendedRanks>());
    CHECK_THROWS_AS(solve(system, method), Unsupported);
    CHECK_THROWS_WITH(solve(system, method),
                      Contains("runs on one rank, got 2 ranks; use \"pcg\""));
  }
}
