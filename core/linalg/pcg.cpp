// Preconditioned conjugate gradients (Hestenes and Stiefel, J. Res. NBS 49 (1952)) on several
// threads and ranks. Rows are summed in fixed blocks, and block sums are added by a BinnedSum.
// Results are therefore bitwise independent of the number of threads and ranks.
//
// The matrix product is memory-bound. The iteration therefore works in single precision. It
// multiplies in difference form (coupling_matrix.h) and on eight rows at once (sliced_ellpack.h).
// The solution is accumulated in double precision. The stopping criterion is the true residual
// r = b - A x in double precision, in the norm sqrt(r . D^-1 r) with the diagonal blocks D. If the
// true residual exceeds the tolerance, the iteration continues from it (residual replacement
// [VanDerVorst2000]). If the tolerance of the system is looser than that of the solver, it
// suffices that the iterated residual, which each step updates by r -= alpha A p, meets the
// tolerance of the system. A later solve with a tighter tolerance can then continue the iteration.
// Systems that single precision cannot solve are solved in double precision.
#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/message.h"
#include "core/linalg/flush_to_zero.h"
#include "core/linalg/matrix_halo.h"
#include "core/linalg/pcg_iteration.h"
#include "core/linalg/pcg_memory.h"
#include "core/linalg/pcg_residual.h"
#include "core/linalg/solvers.h"
#include "core/linalg/system.h"

namespace loomstone {

namespace {

// In single precision, the true residual is computed at the latest when the iterated residual (see
// the top of this file) has fallen to this fraction of its value at the start of the round
// (iterate_to_tolerance()). The fraction is not tuned, because it ends no round if the tolerance is
// 1e-4, the default. It affects the number of matrix products but not the accuracy.
constexpr double trusted_fall = 3e-5;

// Sets the inner and outer blocks. A block is outer if terms act on one of its rows or if one of
// its rows is coupled to a row of another rank. On one rank, all blocks are outer.
void divide_blocks(PcgSolve& solve) {
  const RowLayout& layout = solve.loops.layout();
  PcgMemory& m = solve.memory;
  std::vector<std::uint8_t> outer(solve.loops.n_blocks(), layout.single() ? 1 : 0);
  for (const Halo::Neighbour& neighbour : m.halo.neighbours)
    for (const Index row : neighbour.send) outer[row / rows_per_block] = 1;
  m.terms.for_touched(layout.begin(), layout.end(),
                      [&](Index row) { outer[row / rows_per_block] = 1; });
  m.inner_blocks.clear(), m.outer_blocks.clear();
  const OwnedBlocks owned = owned_blocks(layout);
  for (Index block = owned.first; block < owned.last; ++block)
    (outer[block] != 0 ? m.outer_blocks : m.inner_blocks).push_back(block);
}

// Sets the terms, the halo with the rows of the terms, and the inner and outer blocks.
void set_terms(PcgSolve& solve) {
  const LinearSystem& system = solve.system;
  const RowLayout& layout = solve.loops.layout();
  PcgMemory& m = solve.memory;
  m.terms.build(system.terms, system.term_scale, layout);
  if (!layout.single())
    m.halo = with_term_rows(system.halo ? *system.halo : matrix_halo(*system.matrix, layout),
                            system.terms, layout);
  divide_blocks(solve);
}

// Sets the matrix in single precision, the preconditioner, the terms and the arrays for a new
// matrix.
void set_system(PcgSolve& solve, Preconditioner::Kind kind) {
  const LinearSystem& system = solve.system;
  PcgMemory& m = solve.memory;
  const Index rows = solve.loops.layout().n_rows();
  const RowLayout& layout = solve.loops.layout();
  if (m.slices.set_pattern(system.matrix, {rows, layout.begin(), layout.end()}))
    m.preconditioner.forget_pattern();
  m.x.resize(row_at(layout.end() - layout.begin() + 1));
  m.residual.resize(slice_at(m.slices.n_slices()));
  m.single.resize(m.slices);
  set_terms(solve);
  solve.loops.over_blocks([&](Index, Index begin, Index end) {
    m.single.matrix.set_slices(system.matrix, system.body_blocks, m.slices,
                               m.slices.first_slice(begin), m.slices.last_slice(end));
  });
  m.preconditioner.make(kind, solve.loops, system, {m.terms, m.halo, m.slices});
}

// Replaces the terms while the matrix is unchanged. Builds a new Gauss-Seidel preconditioner, but
// keeps one of another kind, because a new one costs more than the iterations that it may save. If
// aggregation multigrid is kept, time integration takes 0.84, 0.78 and 0.94 times as long as with a
// new one in small versions of the scenes stack, fold and twist, with 1.11, 0.94 and 1.00 times as
// many iterations.
void change_terms(PcgSolve& solve) {
  PcgMemory& m = solve.memory;
  set_terms(solve);
  if (m.preconditioner.kind() == Preconditioner::Kind::GaussSeidel)
    m.preconditioner.make(m.preconditioner.kind(), solve.loops, solve.system,
                          {m.terms, m.halo, m.slices});
}

void set_double_precision(PcgSolve& solve) {
  PcgMemory& m = solve.memory;
  m.wide.resize(m.slices);
  solve.loops.over_blocks([&](Index, Index begin, Index end) {
    m.wide.matrix.set_slices(solve.system.matrix, solve.system.body_blocks, m.slices,
                             m.slices.first_slice(begin), m.slices.last_slice(end));
  });
  m.preconditioner.widen(solve.loops, m.slices);
}

// Properties of the initial guess, combined over all ranks.
struct Guess {
  bool fixed_values = false;  // some fixed row is not zero
  bool free_values = false;   // some free row is not zero
  bool is_known = false;      // the guess equals x of the iteration kept by keep_iteration()
};

Guess look_at(const PcgSolve& solve, const Points& guess) {
  enum { FixedValue, FreeValue, Differs };
  const PcgMemory& m = solve.memory;
  std::vector<std::uint8_t> seen(solve.loops.n_blocks(), 0);
  solve.loops.over_blocks([&](Index block, Index begin, Index end) {
    int flags = 0;  // bit i: property i
    for (Index row = begin; row < end; ++row) {
      if (!guess.row(row).isZero(0.0))
        flags |= 1 << (is_fixed(solve.system, row) ? FixedValue : FreeValue);
      if (m.has_iteration && guess.row(row).transpose() != Eigen::Map<const Vec3>(solve.x_at(row)))
        flags |= 1 << Differs;
    }
    seen[block] = static_cast<std::uint8_t>(flags);
  });
  std::array<BinnedSum, 3> blocks;  // number of blocks with each property
  for (const std::uint8_t flags : seen)
    for (int i = 0; i < 3; ++i) blocks[i].add(flags >> i & 1);
  solve.loops.layout().communicator().add(blocks.data(), 3);
  const auto any = [&](int property) { return blocks[property].value() > 0.0; };
  return {any(FixedValue), any(FreeValue), m.has_iteration && !any(Differs)};
}

// Sets PcgMemory::x. Fixed rows are copied from the guess. Free rows are copied from the guess if
// `free_rows` is set, and are set to zero otherwise.
void set_x(PcgSolve& solve, const Points& guess, bool free_rows) {
  solve.loops.over_blocks([&](Index, Index begin, Index end) {
    for (Index row = begin; row < end; ++row) {
      const bool taken = free_rows || is_fixed(solve.system, row);
      double* const x = solve.x_at(row);
      for (int d = 0; d < 3; ++d) x[d] = taken ? guess(row, d) : 0.0;
      x[3] = 0.0;
    }
  });
}

// Sets x, residual and b_norm in solve.memory. The argument `x` is a guess. Its free rows are used
// if the norm of the residual is smaller with them than with zeros in all free rows. Residuals are
// reported relative to b_norm. Returns the norm of the residual of solve.memory.x.
double start(PcgSolve& solve, const RowsIn& b, const Points& x) {
  PcgMemory& m = solve.memory;
  const Guess guess = look_at(solve, x);
  m.has_iteration = false;
  const double least = least_norm(solve);
  set_x(solve, x, false);
  const double norm_at_zero = true_residual(solve, b, !guess.fixed_values);
  if (!std::isfinite(norm_at_zero)) throw_not_finite(solve.system, b, x);
  m.b_norm = std::max(norm_at_zero, least);
  if (!guess.free_values) return norm_at_zero;
  set_x(solve, x, true);
  const double norm = guess.is_known ? known_residual(solve, b) : true_residual(solve, b, false);
  if (std::isfinite(norm) && norm < norm_at_zero) return norm;
  set_x(solve, x, false);
  return true_residual(solve, b, !guess.fixed_values);
}

// Writes the free rows of x that this rank owns, then gathers the rows of all ranks.
void write_solution(const PcgSolve& solve, Points& x) {
  solve.loops.over_blocks([&](Index, Index begin, Index end) {
    for (Index row = begin; row < end; ++row)
      if (!is_fixed(solve.system, row))
        x.row(row) = Eigen::Map<const Vec3>(solve.x_at(row)).transpose();
  });
  solve.loops.layout().gather(x.data(), 3);
}

class Pcg final : public LinearSolver {
 public:
  Pcg(const LinearOptions& options, Preconditioner::Kind kind) : options_(options), kind_(kind) {}

  LinearReport solve(const Team& team, const LinearSystem& system, const RowsIn& b, Points& x,
                     SolveMemory& memory, Unchanged unchanged) override {
    if (kind_ == Preconditioner::Kind::GaussSeidel && !system.layout->single())
      fail<Unsupported>(
          "the linear solver \"gauss-seidel\" runs on one rank, got {} ranks; use \"pcg\"",
          system.layout->communicator().size());
    check_system(system, b, x);
    const FlushToZero flush;
    PcgMemory& m = memory.pcg();
    PcgSolve solve{system, RowLoops(team, *system.layout), m};
    const bool same_matrix = unchanged != Unchanged::Nothing && m.has_matrix;
    const bool resumes = unchanged == Unchanged::System && same_matrix && m.has_iteration;
    m.has_matrix = false;  // set again unless this solve throws
    m.has_iteration = m.has_iteration && same_matrix;
    if (!same_matrix)
      set_system(solve, kind_);
    else if (!resumes)
      change_terms(solve);
    const double norm = resumes ? m.single.norm * m.b_norm : start(solve, b, x);
    m.has_iteration = false;
    const LinearReport report =
        iterate_to_tolerance(solve, b, norm, resumes ? Start::Resume : Start::Restart);
    m.has_matrix = true;
    write_solution(solve, x);
    return report;
  }

 private:
  // Runs rounds of iterations until the true residual is within the tolerance, or stops without
  // convergence at max_iterations or at the rounding error of double precision. Each round ends
  // with the computation of the true residual, unless a loose tolerance ends the solve first.
  LinearReport iterate_to_tolerance(PcgSolve& solve, const RowsIn& b, double norm,
                                    Start how) const {
    PcgMemory& m = solve.memory;
    LinearReport report;
    if (m.b_norm == 0.0) return report;  // x = 0 on free rows is exact
    const double goal =
        (solve.system.tolerance > 0.0 ? solve.system.tolerance : options_.tolerance) * m.b_norm;
    const bool rough = solve.system.tolerance > options_.tolerance;
    bool in_double = false;
    while (norm > goal && report.iterations < options_.max_iterations) {
      const double before = norm;
      // In single precision, aim slightly below the goal, so that a small difference between the
      // iterated and the true residual does not require another round.
      const double reach = in_double ? goal : std::max(0.97 * goal, trusted_fall * norm);
      const StoppingRule stop{reach, options_.max_iterations};
      const double iterated = in_double ? iterate(solve, m.wide, how, stop, report.iterations)
                                        : iterate(solve, m.single, how, stop, report.iterations);
      if (rough && iterated <= goal) {  // the true residual is not computed
        report.residual = iterated / m.b_norm;
        if (!in_double) keep_iteration(solve, b);
        return report;
      }
      norm = true_residual(solve, b, false);
      if (in_double && !(norm < 0.5 * before)) break;  // limited by rounding in double precision
      how = norm < 2.0 * iterated ? Start::Conjugate : Start::Restart;
      if (!in_double && !(norm < 0.1 * before) && norm > goal &&
          report.iterations < options_.max_iterations) {
        in_double = true;
        how = Start::Restart;
        set_double_precision(solve);
      }
    }
    report.residual = norm / m.b_norm;
    report.converged = norm <= goal;
    return report;
  }

  LinearOptions options_;
  Preconditioner::Kind kind_;
};

}  // namespace

std::unique_ptr<LinearSolver> make_pcg(const LinearOptions& options) {
  return std::make_unique<Pcg>(options, Preconditioner::Kind::Multigrid);
}
std::unique_ptr<LinearSolver> make_block_jacobi(const LinearOptions& options) {
  return std::make_unique<Pcg>(options, Preconditioner::Kind::BlockJacobi);
}
std::unique_ptr<LinearSolver> make_gauss_seidel(const LinearOptions& options) {
  return std::make_unique<Pcg>(options, Preconditioner::Kind::GaussSeidel);
}

}  // namespace loomstone
