// Conjugate gradients preconditioned by the diagonal blocks; on threads and ranks. Hestenes and Stiefel, J. Res. NBS 49
// (1952). Three parallel regions an iteration (four with extra terms); sums by blocks of rows, so the bits depend neither
// on threads nor on ranks.
#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/linalg/matrix_halo.h"
#include "core/linalg/quad.h"
#include "core/linalg/small.h"
#include "core/linalg/solvers.h"
#include "core/linalg/system.h"

namespace loomstone {

namespace {

constexpr Index blocks_per_task = 4;  // 512 rows, about 5 us of work

std::size_t at(Index row) { return 4 * static_cast<std::size_t>(row); }

// Four partial sums, so that additions do not wait for one another; always added in the same order.
struct RowSum {
  Quad part[4] = {};
  LOOMSTONE_INLINE double total() const { return quad_sum((part[0] + part[1]) + (part[2] + part[3])); }
};

LOOMSTONE_CLONES
double dot_rows(Index begin, Index end, const double* a, const double* b) {
  RowSum sum;
  for (Index row = begin; row < end; ++row)
    sum.part[row & 3] += quad_load(a + 4 * static_cast<std::size_t>(row)) * quad_load(b + 4 * static_cast<std::size_t>(row));
  return sum.total();
}

// p = z + beta p
LOOMSTONE_CLONES
void update_direction(std::size_t begin, std::size_t end, double beta, const double* z, double* p) {
  for (std::size_t i = begin; i < end; ++i) p[i] = z[i] + beta * p[i];
}

// z = P^-1 r; returns r . z
LOOMSTONE_CLONES
double precondition_rows(Index begin, Index end, const double* inverse, const double* r, double* z) {
  RowSum sum;
  for (Index row = begin; row < end; ++row) {
    const double* m = inverse + 12 * static_cast<std::size_t>(row);
    const double* residual = r + 4 * static_cast<std::size_t>(row);
    const Quad out = (quad_load(m) * residual[0] + quad_load(m + 4) * residual[1]) + quad_load(m + 8) * residual[2];
    quad_store(z + 4 * static_cast<std::size_t>(row), out);
    sum.part[row & 3] += quad_load(residual) * out;
  }
  return sum.total();
}

// x += alpha p, r -= alpha q, z = P^-1 r; returns r . z
LOOMSTONE_CLONES
double take_step(Index begin, Index end, double alpha, const double* p, const double* q, const double* inverse,
                 double* x, double* r, double* z) {
  RowSum sum;
  for (Index row = begin; row < end; ++row) {
    const std::size_t i = 4 * static_cast<std::size_t>(row);
    const double* m = inverse + 12 * static_cast<std::size_t>(row);
    quad_store(x + i, quad_load(x + i) + alpha * quad_load(p + i));
    const Quad residual = quad_load(r + i) - alpha * quad_load(q + i);
    quad_store(r + i, residual);
    const Quad out = (quad_load(m) * residual[0] + quad_load(m + 4) * residual[1]) + quad_load(m + 8) * residual[2];
    quad_store(z + i, out);
    sum.part[row & 3] += residual * out;
  }
  return sum.total();
}

class Pcg final : public LinearSolver {
 public:
  explicit Pcg(const LinearOptions& options) : options_(options) {}

  LinearReport solve(const Team& team, const LinearSystem& system, const Points& b, Points& x) override {
    check_system(system, b, x);
    system_ = &system;
    team_ = team;
    prepare();
    const double start_norm = start(b, x);
    const LinearReport report = iterate(start_norm);
    finish(x);
    return report;
  }

 private:
  const RowLayout& layout() const { return *system_->layout; }

  // Calls body(block, begin, end) on the owned blocks.
  template <class Body>
  void over_blocks(Body&& body) {
    const OwnedBlocks owned = owned_blocks(layout());
    const Index end_row = layout().end();
    parallel_for(
        team_, owned.last - owned.first,
        [&](Index i) {
          const Index block = owned.first + i, begin = block * rows_per_block;
          body(block, begin, std::min<Index>(end_row, begin + rows_per_block));
        },
        blocks_per_task);
  }

  // Sum of body(block range) over all rows of all ranks.
  template <class Body>
  double sum_over_blocks(Body&& body) {
    over_blocks([&](Index block, Index begin, Index end) { sums_[block] = body(begin, end); });
    return layout().ordered_sum(sums_);
  }

  // Rows of others that the product needs; forces of the terms.
  void refresh(Vector& v) {
    layout().exchange(halo_, v.data(), 4);
    if (!terms_.empty()) terms_.evaluate(team_, v.data());
  }

  void zero_fixed_rows(Index begin, Index end, Vector& v) const {
    if (system_->fixed == nullptr) return;
    for (Index row = begin; row < end; ++row)
      if (is_fixed(*system_, row)) Eigen::Map<Vec4>(v.data() + at(row)).setZero();
  }

  // Scratch, lists of the terms, inverse diagonal blocks (zero where a row is fixed).
  void prepare() {
    const Index rows = layout().n_rows();
    for (Vector* v : {&x_, &r_, &z_, &p_, &q_}) v->resize(4 * rows);
    inverse_.resize(12 * rows);
    sums_.assign((rows + rows_per_block - 1) / rows_per_block, 0.0);
    bad_rows_.assign(sums_.size(), -1);
    terms_.build(system_->terms, system_->term_scale, layout());
    if (!layout().single())
      halo_ = with_term_rows(system_->halo ? *system_->halo : matrix_halo(*system_->matrix, layout()),
                             system_->terms ? *system_->terms : ExtraTerms{}, layout());

    over_blocks([&](Index block, Index begin, Index end) {
      for (Index row = begin; row < end; ++row) {
        Eigen::Map<Eigen::Matrix<double, 4, 3>> padded(inverse_.data() + 12 * static_cast<std::size_t>(row));
        padded.setZero();
        if (is_fixed(*system_, row)) continue;
        Mat3 inverse;
        if (invert_positive_definite(diagonal_block(*system_, terms_, row), inverse))
          padded.topRows<3>() = inverse;
        else if (bad_rows_[block] < 0)
          bad_rows_[block] = row;
      }
    });
    Index bad_row = -1;
    for (std::size_t i = bad_rows_.size(); i-- > 0;)
      if (bad_rows_[i] >= 0) bad_row = bad_rows_[i];
    refuse_indefinite_row(*system_, bad_row);
  }

  // r = b - A x with x the fixed rows alone: its norm is what residuals are measured by. Then the guess is tried.
  double start(const Points& b, const Points& guess) {
    over_blocks([&](Index, Index begin, Index end) {
      for (Index row = begin; row < end; ++row) {
        Eigen::Map<Vec4>(p_.data() + at(row)) << (is_fixed(*system_, row) ? Vec3(guess.row(row)) : Vec3(Vec3::Zero())), 0.0;
        Eigen::Map<Vec4>(x_.data() + at(row)) << (is_fixed(*system_, row) ? Vec3(Vec3::Zero()) : Vec3(guess.row(row))), 0.0;
        Eigen::Map<Vec4>(r_.data() + at(row)) << b.row(row).transpose(), 0.0;
      }
    });
    if (system_->fixed != nullptr) refresh(p_);
    const double b_norm = residual_of(p_, system_->fixed != nullptr);
    if (!std::isfinite(b_norm)) throw_not_finite(*system_, b, guess);
    b_norm_ = b_norm;
    const bool no_guess = x_.segment(at(layout().begin()), at(layout().end()) - at(layout().begin())).isZero(0.0);
    if (layout().communicator().maximum(no_guess ? 0 : 1) == 0) return b_norm;

    // r_ is the right side now; keep it in p_ while the guess is tried.
    over_blocks([&](Index, Index begin, Index end) {
      p_.segment(at(begin), at(end) - at(begin)) = r_.segment(at(begin), at(end) - at(begin));
    });
    refresh(x_);
    const double guess_norm = residual_of(x_, true);
    if (std::isfinite(guess_norm) && guess_norm < b_norm) return guess_norm;
    over_blocks([&](Index, Index begin, Index end) {
      r_.segment(at(begin), at(end) - at(begin)) = p_.segment(at(begin), at(end) - at(begin));
      x_.segment(at(begin), at(end) - at(begin)).setZero();
    });
    return sum_norm();
  }

  // r -= A v (if asked), fixed rows cleared; returns sqrt(r . P^-1 r) and leaves z = P^-1 r.
  double residual_of(const Vector& v, bool subtract) {
    over_blocks([&](Index, Index begin, Index end) {
      if (subtract) {
        multiply_system(*system_, terms_, begin, end, v.data(), q_.data());
        r_.segment(at(begin), at(end) - at(begin)) -= q_.segment(at(begin), at(end) - at(begin));
      }
      zero_fixed_rows(begin, end, r_);
    });
    return sum_norm();
  }

  double sum_norm() {
    rz_ = sum_over_blocks(
        [&](Index begin, Index end) { return precondition_rows(begin, end, inverse_.data(), r_.data(), z_.data()); });
    return std::sqrt(rz_);
  }

  LinearReport iterate(double start_norm) {
    LinearReport report;
    if (b_norm_ == 0.0) return report;  // x = 0 on free rows is exact
    const double goal = options_.tolerance * b_norm_;
    double norm = start_norm, beta = 0.0;
    p_.setZero();
    while (norm > goal && report.iterations < options_.max_iterations) {
      over_blocks([&](Index, Index begin, Index end) {
        update_direction(at(begin), at(end), beta, z_.data(), p_.data());
      });
      refresh(p_);
      const double curvature = sum_over_blocks([&](Index begin, Index end) {
        multiply_system(*system_, terms_, begin, end, p_.data(), q_.data());
        zero_fixed_rows(begin, end, q_);
        return dot_rows(begin, end, p_.data(), q_.data());
      });
      if (!(curvature > 0.0) || !std::isfinite(curvature)) throw_indefinite("pcg", report.iterations + 1);
      const double alpha = rz_ / curvature;
      const double rz = sum_over_blocks([&](Index begin, Index end) {
        return take_step(begin, end, alpha, p_.data(), q_.data(), inverse_.data(), x_.data(), r_.data(), z_.data());
      });
      beta = rz / rz_;
      rz_ = rz;
      norm = std::sqrt(rz);
      ++report.iterations;
    }
    report.residual = norm / b_norm_;
    report.converged = norm <= goal;
    return report;
  }

  void finish(Points& x) {
    over_blocks([&](Index, Index begin, Index end) {
      for (Index row = begin; row < end; ++row)
        if (!is_fixed(*system_, row)) x.row(row) = Eigen::Map<const Vec3>(x_.data() + at(row)).transpose();
    });
    layout().gather(x.data(), 3);
    system_ = nullptr;
  }

  LinearOptions options_;
  // Scratch of one solve; vectors have four doubles a row.
  const LinearSystem* system_ = nullptr;
  Team team_;
  TermRows terms_;
  Halo halo_;
  Vector x_, r_, z_, p_, q_, inverse_;  // inverse_: 3 columns of 4 a row
  std::vector<double> sums_;
  std::vector<Index> bad_rows_;
  double rz_ = 0.0, b_norm_ = 0.0;
};

}  // namespace

std::unique_ptr<LinearSolver> make_pcg(const LinearOptions& options) { return std::make_unique<Pcg>(options); }

}  // namespace loomstone
