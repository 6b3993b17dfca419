// Times of computing the row order, the product of a block matrix and a vector, and linear solves
// for square cloths with `side` vertices along each edge (default: 86, which gives 7,396 vertices).
// Usage: benchmark_linalg [threads] [side ...], or --smoke (tiny). Each time is the minimum of
// several repetitions, except that of the row order. Results of different machines can be compared
// by the ratio of a time to that of the product in the same run. Reference for 7,396 vertices (one
// thread, AVX-512): a product takes 0.05 ms, and a solve of 51 iterations takes 3.7 ms, which is 74
// products.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "core/linalg/linear_solver.h"
#include "core/parallel/vertex_order.h"

using namespace loomstone;

namespace {

double least_milliseconds(int repetitions, const std::function<void()>& body) {
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < repetitions; ++i) {
    const auto start = std::chrono::steady_clock::now();
    body();
    least = std::min(
        least, std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
                   .count());
  }
  return least;
}

// Couplings along grid edges and one diagonal per cell, in the row order of a simulation.
std::vector<std::pair<Index, Index>> ordered_couplings(Index side) {
  std::vector<std::pair<Index, Index>> couplings;
  for (Index r = 0; r < side; ++r)
    for (Index c = 0; c < side; ++c) {
      const Index v = r * side + c;
      if (c + 1 < side) couplings.push_back({v, v + 1});
      if (r + 1 < side) couplings.push_back({v, v + side});
      if (r + 1 < side && c + 1 < side) couplings.push_back({v, v + side + 1});
    }
  Graph graph;
  std::vector<std::vector<Index>> lists(side * side);
  for (const auto& [i, j] : couplings) lists[i].push_back(j), lists[j].push_back(i);
  graph.start.push_back(0);
  for (const auto& list : lists) {
    graph.adjacent.insert(graph.adjacent.end(), list.begin(), list.end());
    graph.start.push_back(static_cast<Index>(graph.adjacent.size()));
  }
  const auto start = std::chrono::steady_clock::now();
  const std::vector<Index> order = bisection_order(graph);
  std::printf(
      "bisection order %.1f ms\n",
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
  std::vector<Index> place(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) place[order[i]] = static_cast<Index>(i);
  for (auto& [i, j] : couplings) i = place[i], j = place[j];
  return couplings;
}

// Matrix of unit masses and of springs whose directions are (1, 0, 0), (0, 1, 0) and (1, 1, 0) in
// turn. Each spring has `stiffness` along its direction, and a tenth of it perpendicular to that.
BlockMatrix cloth_like(Index side, double stiffness) {
  const auto couplings = ordered_couplings(side);
  BlockMatrix matrix(side * side, couplings);
  for (Index row = 0; row < matrix.n_rows(); ++row)
    matrix.block_map(matrix.diagonal()[row]).setIdentity();
  const Vec3 directions[3] = {{1, 0, 0}, {0, 1, 0}, Vec3(1, 1, 0).normalized()};
  for (std::size_t k = 0; k < couplings.size(); ++k) {
    const auto [i, j] = couplings[k];
    const Vec3& d = directions[k % 3];
    const Mat3 block = stiffness * (0.9 * d * d.transpose() + 0.1 * Mat3::Identity());
    for (const Index row : {i, j}) matrix.block_map(matrix.diagonal()[row]) += block;
    matrix.block_map(matrix.find(i, j)) -= block;
    matrix.block_map(matrix.find(j, i)) -= block;
  }
  return matrix;
}

// Imitates contacts by one term of four rows for every ten rows.
ExtraTerms contacts(Index n_rows) {
  ExtraTerms terms;
  for (Index row = 0; row + 40 < n_rows; row += 10) {
    ExtraTerm term;
    const double weights[4] = {1.0, -0.2, -0.3, -0.5};
    for (int e = 0; e < 4; ++e)
      term.entries[term.n_entries++] = {row + 11 * e, false, weights[e], Vec3::Zero()};
    term.hessian = 20.0 * Vec3(0, 0, 1) * Vec3(0, 0, 1).transpose();
    terms.push_back(term);
  }
  return terms;
}

void benchmark(int threads, Index side) {
  const BlockMatrix matrix = cloth_like(side, 10.0);
  const Index n = matrix.n_rows();
  const int repetitions = std::max(20, 400000 / n);
  std::printf("%d vertices, %d blocks, %d threads\n", n, matrix.n_blocks(), threads);
  Vector x = Vector::Random(4 * n), y(4 * n);
  const double product =
      least_milliseconds(10 * repetitions, [&] { matrix.multiply(0, n, x.data(), y.data()); });
  std::printf("  product (one thread)               %8.4f ms\n", product);

  const RowLayout layout(n, single_communicator());
  const Points b = Points::Random(n, 3), zero = Points::Zero(n, 3);
  const ExtraTerms terms = contacts(n);
  for (const bool with_terms : {false, true})
    for (const LinearMethod method :
         {LinearMethod::Pcg, LinearMethod::GaussSeidel, LinearMethod::Direct}) {
      const auto solver = make_linear_solver({method, 1e-4, 2000});
      LinearSystem system;
      system.matrix = &matrix;
      system.layout = &layout;
      system.terms = with_terms ? &terms : nullptr;
      system.term_scale = 1.0;
      Points solution;
      SolveMemory memory;
      LinearReport report;
      const bool direct = method == LinearMethod::Direct;
      const double time = least_milliseconds(direct ? 3 : repetitions, [&] {
        solution = zero;
        report = solver->solve(Team{threads}, system, b, solution, memory, Unchanged::Nothing);
      });
      std::printf("  %-12s %-9s %4d iterations %8.3f ms, %7.4f ms each, %6.1f products\n",
                  std::string(name_of(method)).c_str(), with_terms ? "contacts" : "",
                  report.iterations, time, time / report.iterations, time / product);
    }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 2 && std::string(argv[1]) == "--smoke") {
    benchmark(1, 12);
    return 0;
  }
  const int threads = argc > 1 ? std::atoi(argv[1]) : 1;
  std::vector<Index> sides;
  for (int i = 2; i < argc; ++i) sides.push_back(std::atoi(argv[i]));
  if (sides.empty()) sides = {86};
  for (const Index side : sides) benchmark(threads, side);
}
