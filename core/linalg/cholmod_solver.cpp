// Direct solve by sparse Cholesky factorisation with CHOLMOD (Chen, Davis, Hager and Rajamanickam,
// "Algorithm 887: CHOLMOD", ACM Trans. Math. Softw. 35 (2008)). Only this file includes CHOLMOD.
// The symbolic analysis is reused while the pattern of matrix and terms is unchanged. It depends on
// this pattern alone, so a rebuilt solver gives bitwise identical results.
//
// LinearMethod::Direct selects the simplicial factorisation. It uses only modules of CHOLMOD under
// the LGPL and no BLAS, so its results do not depend on the installed BLAS.
// LinearMethod::Supernodal selects the supernodal factorisation, which uses dense blocks and BLAS.
// It needs a module of CHOLMOD that is under the GPL and that some builds of CHOLMOD lack.
#include <cholmod.h>
#include <dlfcn.h>

#include <algorithm>
#include <cmath>

#include "core/base/message.h"
#include "core/base/sort_unique.h"
#include "core/linalg/solvers.h"
#include "core/linalg/system.h"
#include "core/parallel/nested_regions.h"

namespace loomstone {

namespace {

bool has_supernodal_module() { return dlsym(RTLD_DEFAULT, "cholmod_super_numeric") != nullptr; }

// If OpenBLAS is loaded, restricts it to one thread, because its results depend on the number of
// threads.
void use_one_blas_thread() {
  if (void* set = dlsym(RTLD_DEFAULT, "openblas_set_num_threads"))
    reinterpret_cast<void (*)(int)>(set)(1);
}

using Couplings = std::vector<std::pair<Index, Index>>;

class DirectSolver final : public LinearSolver {
 public:
  explicit DirectSolver(bool supernodal) : supernodal_(supernodal) {
    cholmod_start(&common_);
    common_.print = 0;
    common_.supernodal = supernodal ? CHOLMOD_SUPERNODAL : CHOLMOD_SIMPLICIAL;
    // Requests a factorisation L L^T even if the factor is simplicial, so that a negative pivot is
    // an error.
    common_.final_ll = 1;
  }
  ~DirectSolver() override {
    cholmod_free_factor(&factor_, &common_);
    cholmod_finish(&common_);
  }
  DirectSolver(const DirectSolver&) = delete;
  DirectSolver& operator=(const DirectSolver&) = delete;

  LinearReport solve(const Team&, const LinearSystem& system, const RowsIn& b, Points& x,
                     SolveMemory&, Unchanged) override {
    if (!system.layout->single())
      fail<Unsupported>("the linear solver \"{}\" runs on one rank, got {} ranks; use \"pcg\"",
                        name_of(supernodal_ ? LinearMethod::Supernodal : LinearMethod::Direct),
                        system.layout->communicator().size());
    check_system(system, b, x);
    update_pattern(system);
    assemble(system);
    move_prescribed_to_right(system, b, x);
    if (!right_.allFinite()) throw_not_finite(system, b, x);
    fill_columns(system);
    factorize();
    back_substitute();
    return finish(system, x);
  }

 private:
  // Builds and analyses the joint pattern of matrix, bodies and terms if it has changed.
  void update_pattern(const LinearSystem& system) {
    Couplings extra = couplings_outside(system);
    const Index rows = system.layout->n_rows(), n_cloth = n_cloth_rows(system);
    const bool same = factor_ != nullptr && whole_.n_rows() == rows && n_cloth_ == n_cloth &&
                      extra == extra_ &&
                      (n_cloth == 0 || (system.matrix->columns() == matrix_columns_ &&
                                        system.matrix->row_start() == matrix_start_));
    if (same) return;
    extra_ = std::move(extra);
    n_cloth_ = n_cloth;
    Couplings all = extra_;
    if (n_cloth > 0) {
      matrix_columns_ = system.matrix->columns();
      matrix_start_ = system.matrix->row_start();
      for (Index row = 0; row < n_cloth; ++row)
        for (Index k = matrix_start_[row]; k < system.matrix->diagonal()[row]; ++k)
          all.push_back({row, matrix_columns_[k]});
    }
    whole_ = BlockMatrix(rows, all);
    place_.resize(n_cloth > 0 ? system.matrix->n_blocks() : 0);
    for (Index row = 0; row < n_cloth; ++row)
      for (Index k = matrix_start_[row]; k < matrix_start_[row + 1]; ++k)
        place_[k] = whole_.find(row, matrix_columns_[k]);
    lay_out_columns();
    cholmod_free_factor(&factor_, &common_);
    cholmod_sparse lower = lower_triangle();
    factor_ = cholmod_analyze(&lower, &common_);
    if (factor_ == nullptr)
      throw SolverFailure(
          "direct solve: the symbolic analysis needs more memory than is available; use \"pcg\"");
  }

  // Returns the sorted pairs of rows that terms couple but the matrix does not.
  static Couplings couplings_outside(const LinearSystem& system) {
    Couplings found;
    if (system.terms == nullptr) return found;
    const Index n_cloth = n_cloth_rows(system);
    for (const ExtraTerm& term : *system.terms)
      for (int a = 0; a < term.n_entries; ++a)
        for (int b = 0; b < a; ++b) {
          const Index high = std::max(term.entries[a].row, term.entries[b].row);
          const Index low = std::min(term.entries[a].row, term.entries[b].row);
          if (high == low || (high < n_cloth && system.matrix->find(high, low) >= 0)) continue;
          found.push_back({high, low});
        }
    sort_unique(found);
    return found;
  }

  // Builds the compressed-column pattern of the lower triangle, in scalar entries. Column 3 j + c
  // contains the rows 3 i + d of all blocks i > j, and those with d >= c of block i = j.
  void lay_out_columns() {
    column_start_.assign(1, 0);
    row_index_.clear();
    for (Index j = 0; j < whole_.n_rows(); ++j)
      for (int c = 0; c < 3; ++c) {
        for (Index k = whole_.diagonal()[j]; k < whole_.row_start()[j + 1]; ++k) {
          const Index i = whole_.columns()[k];
          for (int d = i == j ? c : 0; d < 3; ++d) row_index_.push_back(3 * i + d);
        }
        column_start_.push_back(static_cast<int>(row_index_.size()));
      }
    entries_.assign(row_index_.size(), 0.0);
  }

  cholmod_sparse lower_triangle() {
    cholmod_sparse view{};
    view.nrow = view.ncol = 3 * static_cast<std::size_t>(whole_.n_rows());
    view.nzmax = row_index_.size();
    view.p = column_start_.data();
    view.i = row_index_.data();
    view.x = entries_.data();
    view.stype = -1;
    view.itype = CHOLMOD_INT;
    view.xtype = CHOLMOD_REAL;
    view.dtype = CHOLMOD_DOUBLE;
    view.sorted = view.packed = 1;
    return view;
  }

  void assemble(const LinearSystem& system) {
    whole_.set_zero();
    for (std::size_t k = 0; k < place_.size(); ++k)
      whole_.block_map(place_[k]) = system.matrix->block_map(static_cast<Index>(k));
    for (Index row = n_cloth_; row < whole_.n_rows(); ++row)
      whole_.block_map(whole_.diagonal()[row]) = (*system.body_blocks)[row - n_cloth_];
    if (system.terms == nullptr) return;
    for (const ExtraTerm& term : *system.terms)
      for (int a = 0; a < term.n_entries; ++a) {
        const Mat3 left =
            system.term_scale * (term.entries[a].jacobian().transpose() * term.hessian);
        for (int b = 0; b < term.n_entries; ++b)
          whole_.block_map(whole_.find(term.entries[a].row, term.entries[b].row)) +=
              left * term.entries[b].jacobian();
      }
  }

  // Computes right_ = b - A x_f, where x_f is x on fixed rows and zero on free rows. Fixed rows of
  // right_ are zero.
  void move_prescribed_to_right(const LinearSystem& system, const RowsIn& b, const Points& x) {
    const Index rows = whole_.n_rows();
    padded_.setZero(4 * rows);
    product_.setZero(4 * rows);
    right_.resize(3 * rows);
    if (system.fixed != nullptr) {
      for (Index row = 0; row < rows; ++row)
        if (is_fixed(system, row)) padded_.segment<3>(4 * row) = x.row(row).transpose();
      whole_.multiply(0, rows, padded_.data(), product_.data());
    }
    for (Index row = 0; row < rows; ++row)
      right_.segment<3>(3 * row) =
          is_fixed(system, row) ? Vec3(Vec3::Zero())
                                : Vec3(b.row(row).transpose() - product_.segment<3>(4 * row));
  }

  // Copies the lower triangle of whole_ to the compressed columns, with fixed rows and columns
  // replaced by those of the identity. The pattern does not change.
  void fill_columns(const LinearSystem& system) {
    double* entry = entries_.data();
    for (Index j = 0; j < whole_.n_rows(); ++j)
      for (int c = 0; c < 3; ++c)
        for (Index k = whole_.diagonal()[j]; k < whole_.row_start()[j + 1]; ++k) {
          const Index i = whole_.columns()[k];
          const bool cut = is_fixed(system, i) || is_fixed(system, j);
          const double* block = whole_.block(k);  // block (j, i), the transpose of block (i, j)
          for (int d = i == j ? c : 0; d < 3; ++d)
            *entry++ = cut ? (i == j && c == d ? 1.0 : 0.0) : block[c + 3 * d];
        }
  }

  void factorize() {
    if (supernodal_) use_one_blas_thread();
    const NoNestedRegions serial;  // otherwise CHOLMOD may start several threads
    cholmod_sparse lower = lower_triangle();
    cholmod_factorize(&lower, factor_, &common_);
    if (common_.status == CHOLMOD_NOT_POSDEF) {
      const int row = static_cast<const int*>(factor_->Perm)[factor_->minor] / 3;
      fail<StepFailure>(
          "linear solve: the matrix must be positive definite, got a negative pivot in row {} "
          "(direct); reduce the step size",
          row);
    }
    if (common_.status < CHOLMOD_OK)
      throw SolverFailure(
          "direct solve: the factor needs more memory than is available; use \"pcg\"");
  }

  void back_substitute() {
    cholmod_dense right{};
    right.nrow = right.d = right.nzmax = static_cast<std::size_t>(right_.size());
    right.ncol = 1;
    right.x = right_.data();
    right.xtype = CHOLMOD_REAL;
    right.dtype = CHOLMOD_DOUBLE;
    const NoNestedRegions serial;
    cholmod_dense* solution = cholmod_solve(CHOLMOD_A, factor_, &right, &common_);
    if (solution == nullptr)
      throw SolverFailure("direct solve: no memory for the solution; use \"pcg\"");
    const double* values = static_cast<const double*>(solution->x);
    for (Index row = 0; row < whole_.n_rows(); ++row)
      padded_.segment<4>(4 * row) << values[3 * row], values[3 * row + 1], values[3 * row + 2], 0.0;
    cholmod_free_dense(&solution, &common_);
  }

  LinearReport finish(const LinearSystem& system, Points& x) {
    whole_.multiply(0, whole_.n_rows(), padded_.data(), product_.data());
    double squared_residual = 0.0;
    for (Index row = 0; row < whole_.n_rows(); ++row) {
      if (is_fixed(system, row)) continue;
      x.row(row) = padded_.segment<3>(4 * row).transpose();
      squared_residual += (right_.segment<3>(3 * row) - product_.segment<3>(4 * row)).squaredNorm();
    }
    LinearReport report;
    report.iterations = 1;
    const double b_norm = right_.norm();
    report.residual = b_norm > 0.0 ? std::sqrt(squared_residual) / b_norm : 0.0;
    if (!std::isfinite(squared_residual))
      throw StepFailure(
          "linear solve: the matrix must be finite, got a solution with NaN or infinity (direct); "
          "check the forces and the step size");
    return report;
  }

  bool supernodal_;
  cholmod_common common_;
  // These members are reused while the joint pattern is unchanged. Each solve replaces the matrix
  // entries in factor_ and whole_.
  cholmod_factor* factor_ = nullptr;
  Index n_cloth_ = 0;
  std::vector<Index> matrix_columns_, matrix_start_;
  Couplings extra_;
  BlockMatrix whole_;
  std::vector<Index> place_;  // index in whole_ of each block of the matrix
  std::vector<int> column_start_, row_index_;
  // Scratch memory of one solve.
  std::vector<double> entries_;
  Vector right_, padded_, product_;
};

}  // namespace

std::unique_ptr<LinearSolver> make_cholmod(const LinearOptions& options) {
  const bool supernodal = options.method == LinearMethod::Supernodal;
  if (supernodal && !has_supernodal_module())
    throw Unsupported(
        "the linear solver \"supernodal\" needs a CHOLMOD with its supernodal module, which this "
        "build of loomstone lacks; use \"direct\", or build loomstone from its sources");
  return std::make_unique<DirectSolver>(supernodal);
}

}  // namespace loomstone
