// Conjugate gradients preconditioned by symmetric block Gauss-Seidel, in the form that needs two half products an
// iteration. Implements Eisenstat, "Efficient implementation of a class of preconditioned conjugate gradient methods",
// SIAM J. Sci. Stat. Comput. 2 (1981), with one addition of ours: extra terms outside the preconditioner.
//
// A = L + D + L^T + E with L the strictly lower blocks of the matrix and E the extra terms. The preconditioner is
// (S + L) S^-1 (S + L)^T with S = D + diag(E). In r^ = (S + L)^-1 r and p^ = (S + L)^T p the matrix becomes
//   A^ p^ = t + (S + L)^-1 (p^ - S t + (E - diag E) t),   t = (S + L)^-T p^,
// with S as preconditioner, and p^ - S t = L^T t falls out of the backward sweep.
// The sweeps are bound by memory: L and L^T are kept in single precision, in the order in which the sweeps read them. D makes
// up for the rounding, so that row sums, and with them the mass of a common translation, stay those of A: what changes is
// each stiffness, by 6e-8 of itself. The residual that A leaves, in double precision, decides when to stop.
// One thread, one rank: the sweeps are sequential.
#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/linalg/quad.h"
#include "core/linalg/small.h"
#include "core/linalg/solvers.h"
#include "core/linalg/system.h"

namespace loomstone {

namespace {

const Team one_thread{1};

// A and what the sweeps use of it differ by 6e-8: a fall of the iterated residual is trusted this far.
constexpr double trusted_fall = 1e-6;

// Order of rows in which neighbours in the list do not wait for one another: by level of dependency, a row's level being
// one more than the largest of the earlier rows it is coupled to. The result of a sweep does not depend on it.
std::vector<Index> order_by_level(const BlockMatrix* matrix, Index n_rows) {
  std::vector<Index> level(n_rows, 0);
  Index n_levels = 1;
  for (Index row = 0; matrix != nullptr && row < matrix->n_rows(); ++row) {
    for (Index k = matrix->row_start()[row]; k < matrix->diagonal()[row]; ++k)
      level[row] = std::max(level[row], level[matrix->columns()[k]] + 1);
    n_levels = std::max(n_levels, level[row] + 1);
  }
  std::vector<Index> start(n_levels + 1, 0), order(n_rows);
  for (const Index of_row : level) ++start[of_row + 1];
  for (Index i = 0; i < n_levels; ++i) start[i + 1] += start[i];
  for (Index row = 0; row < n_rows; ++row) order[start[level[row]]++] = row;
  return order;
}

// Blocks of the rows in the order of the sweeps, nine floats each.
struct Triangle {
  std::vector<Index> start, columns;  // (rows + 1) by place in the order; (blocks)
  std::vector<float> values;          // 3 more at the end so that a column may be loaded 4 wide

  void add(Index column, const double* block) {
    columns.push_back(column);
    for (int k = 0; k < 9; ++k) values.push_back(static_cast<float>(block[k]));
  }
};

struct Sweep {
  const Index* order;
  const Triangle &lower, &upper;
  const double* inverse;  // S^-1, 12 a row
  Index n_rows;
};

LOOMSTONE_INLINE Quad block_times(const double* padded, const Quad& v) {
  return (quad_load(padded) * v[0] + quad_load(padded + 4) * v[1]) + quad_load(padded + 8) * v[2];
}

LOOMSTONE_INLINE Quad widened(const float* p) { return __builtin_convertvector(quad_load(p), Quad); }

// Sum of the blocks of a place times their rows of v.
LOOMSTONE_INLINE Quad gather_blocks(const Triangle& blocks, Index place, const double* v) {
  Quad sum0{}, sum1{}, sum2{};
  for (Index k = blocks.start[place]; k < blocks.start[place + 1]; ++k) {
    const float* a = blocks.values.data() + 9 * static_cast<std::size_t>(k);
    const double* u = v + 4 * static_cast<std::size_t>(blocks.columns[k]);
    sum0 += widened(a) * u[0];
    sum1 += widened(a + 3) * u[1];
    sum2 += widened(a + 6) * u[2];
  }
  Quad sum = (sum0 + sum1) + sum2;
  sum[3] = 0.0;
  return sum;
}

// p = z + beta p; t = (S + L)^-T p; u = L^T t
LOOMSTONE_CLONES
void sweep_backward(const Sweep& s, double beta, const double* z, double* p, double* t, double* u) {
  for (Index place = s.n_rows; place-- > 0;) {
    const std::size_t i = 4 * static_cast<std::size_t>(s.order[place]);
    const Quad direction = quad_load(z + i) + beta * quad_load(p + i);
    const Quad upper = gather_blocks(s.upper, place, t);
    quad_store(p + i, direction);
    quad_store(u + i, upper);
    quad_store(t + i, block_times(s.inverse + 3 * i, direction - upper));
  }
}

// w = (S + L)^-1 u, in place of u
LOOMSTONE_CLONES
void sweep_forward(const Sweep& s, double* u) {
  for (Index place = 0; place < s.n_rows; ++place) {
    const std::size_t i = 4 * static_cast<std::size_t>(s.order[place]);
    const Quad lower = gather_blocks(s.lower, place, u);
    quad_store(u + i, block_times(s.inverse + 3 * i, quad_load(u + i) - lower));
  }
}

// Returns p . (t + w)
LOOMSTONE_CLONES
double curvature_along(Index n_rows, const double* p, const double* t, const double* w) {
  Quad part[4] = {};
  for (Index row = 0; row < n_rows; ++row) {
    const std::size_t i = 4 * static_cast<std::size_t>(row);
    part[row & 3] += quad_load(p + i) * (quad_load(t + i) + quad_load(w + i));
  }
  return quad_sum((part[0] + part[1]) + (part[2] + part[3]));
}

// x += alpha t; r -= alpha (t + w); z = S r; returns r . z
LOOMSTONE_CLONES
double take_step(Index n_rows, double alpha, const double* t, const double* w, const double* diagonal, double* x,
                 double* r, double* z) {
  Quad part[4] = {};
  for (Index row = 0; row < n_rows; ++row) {
    const std::size_t i = 4 * static_cast<std::size_t>(row);
    const Quad direction = quad_load(t + i);
    quad_store(x + i, quad_load(x + i) + alpha * direction);
    const Quad residual = quad_load(r + i) - alpha * (direction + quad_load(w + i));
    quad_store(r + i, residual);
    const Quad out = block_times(diagonal + 3 * i, residual);
    quad_store(z + i, out);
    part[row & 3] += residual * out;
  }
  return quad_sum((part[0] + part[1]) + (part[2] + part[3]));
}

class GaussSeidel final : public LinearSolver {
 public:
  explicit GaussSeidel(const LinearOptions& options) : options_(options) {}

  LinearReport solve(const Team&, const LinearSystem& system, const Points& b, Points& x) override {
    if (!system.layout->single())
      throw Unsupported("the linear solver \"gauss-seidel\" runs on one rank, got " +
                        std::to_string(system.layout->communicator().size()) + " ranks; use \"pcg\"");
    check_system(system, b, x);
    prepare(system);
    const double start_norm = start(system, b, x);
    const LinearReport report = iterate(system, start_norm);
    for (Index row = 0; row < n_rows_; ++row)
      if (!is_fixed(system, row)) x.row(row) = x_.segment<3>(4 * row).transpose();
    return report;
  }

 private:
  void prepare(const LinearSystem& system) {
    n_rows_ = system.layout->n_rows();
    const Index n_cloth = n_cloth_rows(system);
    const bool same_pattern = static_cast<Index>(order_.size()) == n_rows_ && pattern_rows_ == n_cloth &&
                              (n_cloth == 0 || (system.matrix->columns() == pattern_columns_ &&
                                                system.matrix->row_start() == pattern_start_));
    if (!same_pattern) {
      order_ = order_by_level(system.matrix, n_rows_);
      pattern_rows_ = n_cloth;
      if (n_cloth > 0) pattern_columns_ = system.matrix->columns(), pattern_start_ = system.matrix->row_start();
    }
    for (Vector* v : {&x_, &r_, &z_, &p_, &t_, &w_}) v->resize(4 * n_rows_);
    inverse_.resize(12 * n_rows_);
    diagonal_.resize(12 * n_rows_);
    terms_.build(system.terms, system.term_scale, *system.layout);
    term_diagonals_.clear();
    for (Triangle* blocks : {&lower_, &upper_}) blocks->start.assign(1, 0), blocks->columns.clear(), blocks->values.clear();
    Index bad_row = -1;
    for (const Index row : order_)
      if (!prepare_row(system, row) && (bad_row < 0 || row < bad_row)) bad_row = row;
    for (Triangle* blocks : {&lower_, &upper_}) blocks->values.resize(blocks->values.size() + 3);
    refuse_indefinite_row(system, bad_row);
  }

  // Blocks of the row, its S and S^-1 (zero where it is fixed); false where S is not positive definite.
  bool prepare_row(const LinearSystem& system, Index row) {
    Eigen::Map<Eigen::Matrix<double, 4, 3>> inverse(inverse_.data() + 12 * row), diagonal(diagonal_.data() + 12 * row);
    inverse.setZero();
    diagonal.setZero();
    Mat3 block = diagonal_block(system, terms_, row);
    if (row < n_cloth_rows(system)) {
      const BlockMatrix& a = *system.matrix;
      for (Index k = a.row_start()[row]; k < a.row_start()[row + 1]; ++k) {
        if (k == a.diagonal()[row]) continue;
        (k < a.diagonal()[row] ? lower_ : upper_).add(a.columns()[k], a.block(k));
        block += a.block_map(k) - a.block_map(k).cast<float>().cast<double>();
      }
    }
    for (Triangle* blocks : {&lower_, &upper_}) blocks->start.push_back(static_cast<Index>(blocks->columns.size()));
    if (is_fixed(system, row)) return true;
    if (terms_.touches(row)) term_diagonals_.push_back({row, terms_.diagonal(row)});
    block = (0.5 * (block + block.transpose())).eval();
    Mat3 inverted;
    if (!invert_positive_definite(block, inverted)) return false;
    inverse.topRows<3>() = inverted;
    diagonal.topRows<3>() = block;
    return true;
  }

  Sweep sweep() const { return {order_.data(), lower_, upper_, inverse_.data(), n_rows_}; }

  // r_ = (S + L)^-1 (b - A x), z_ = S r_; returns the preconditioned norm.
  double transformed_residual(const LinearSystem& system) {
    for (Index row = 0; row < n_rows_; ++row)
      if (is_fixed(system, row)) r_.segment<4>(4 * row).setZero();
    sweep_forward(sweep(), r_.data());
    t_.setZero();
    rz_ = take_step(n_rows_, 0.0, t_.data(), t_.data(), diagonal_.data(), x_.data(), r_.data(), z_.data());
    return std::sqrt(rz_);
  }

  void subtract_product(const LinearSystem& system, const Vector& v) {
    if (!terms_.empty()) terms_.evaluate(one_thread, v.data());
    multiply_system(system, terms_, 0, n_rows_, v.data(), t_.data());
    r_ -= t_;
  }

  double start(const LinearSystem& system, const Points& b, const Points& guess) {
    x_.setZero();
    p_.setZero();
    for (Index row = 0; row < n_rows_; ++row) {
      (is_fixed(system, row) ? p_ : x_).segment<3>(4 * row) = guess.row(row).transpose();
      r_.segment<4>(4 * row) << b.row(row).transpose(), 0.0;
    }
    if (system.fixed != nullptr) subtract_product(system, p_);  // prescribed values, to the right side
    right_ = r_;
    b_norm_ = transformed_residual(system);
    if (!std::isfinite(b_norm_)) throw_not_finite(system, b, guess);
    if (x_.isZero(0.0)) return b_norm_;
    r_ = right_;
    subtract_product(system, x_);
    const double guess_norm = transformed_residual(system);
    if (std::isfinite(guess_norm) && guess_norm < b_norm_) return guess_norm;
    x_.setZero();
    r_ = right_;
    return transformed_residual(system);
  }

  LinearReport iterate(const LinearSystem& system, double norm) {
    LinearReport report;
    if (b_norm_ == 0.0) return report;  // x = 0 on free rows is exact
    const double goal = options_.tolerance * b_norm_;
    while (norm > goal && report.iterations < options_.max_iterations) {
      const double before = norm;
      run(std::max(0.99 * goal, trusted_fall * norm), report.iterations);
      r_ = right_;
      subtract_product(system, x_);
      norm = transformed_residual(system);
      if (!(norm < 0.5 * before)) break;  // rounding of double precision
    }
    report.residual = norm / b_norm_;
    report.converged = norm <= goal;
    return report;
  }

  // Iterates from r_ until the iterated norm is below `reach`.
  void run(double reach, int& iterations) {
    double beta = 0.0;
    p_.setZero();
    t_.setZero();
    while (std::sqrt(rz_) > reach && iterations < options_.max_iterations) {
      sweep_backward(sweep(), beta, z_.data(), p_.data(), t_.data(), w_.data());
      add_terms();
      sweep_forward(sweep(), w_.data());
      const double curvature = curvature_along(n_rows_, p_.data(), t_.data(), w_.data());
      if (!(curvature > 0.0) || !std::isfinite(curvature)) throw_indefinite("gauss-seidel", iterations + 1);
      const double rz = take_step(n_rows_, rz_ / curvature, t_.data(), w_.data(), diagonal_.data(), x_.data(),
                                  r_.data(), z_.data());
      beta = rz / rz_;
      rz_ = rz;
      ++iterations;
    }
  }

  // w += (E - diag E) t
  void add_terms() {
    if (terms_.empty()) return;
    terms_.evaluate(one_thread, t_.data());
    for (const auto& [row, diagonal] : term_diagonals_) {
      w_.segment<3>(4 * row) += terms_.force(row) - diagonal * t_.segment<3>(4 * row);
    }
  }

  LinearOptions options_;
  // Kept while the pattern stays; a function of the pattern alone.
  std::vector<Index> order_, pattern_columns_, pattern_start_;
  Index pattern_rows_ = 0;
  // Scratch of one solve.
  struct RowBlock {
    Index row;
    Mat3 block;
  };
  std::vector<RowBlock> term_diagonals_;  // of free rows
  TermRows terms_;
  Triangle lower_, upper_;
  Index n_rows_ = 0;
  Vector right_, x_, r_, z_, p_, t_, w_, inverse_, diagonal_;
  double rz_ = 0.0, b_norm_ = 0.0;
};

}  // namespace

std::unique_ptr<LinearSolver> make_gauss_seidel(const LinearOptions& options) {
  return std::make_unique<GaussSeidel>(options);
}

}  // namespace loomstone
