// Conjugate gradients preconditioned by the diagonal blocks; on threads and ranks. Hestenes and Stiefel, J. Res. NBS 49
// (1952). Three parallel regions an iteration (four with extra terms); sums by blocks of rows, so the bits depend neither
// on threads nor on ranks.
//
// The product is bound by memory, so the iteration works in single precision, on couplings (single_matrix.h); the solution
// is summed in double precision, and the residual it really leaves, in double precision, decides when to stop. Where that
// residual has drifted from the iterated one the iteration goes on from it [VanDerVorst2000]. What single precision cannot
// solve is solved in double precision.
#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/linalg/matrix_halo.h"
#include "core/linalg/pcg_kernels.h"
#include "core/linalg/single_matrix.h"
#include "core/linalg/small.h"
#include "core/linalg/solvers.h"
#include "core/linalg/system.h"

namespace loomstone {

namespace {

constexpr Index least_blocks_a_thread = 4;  // 512 rows, about 5 us of work
// How far the iterated residual in single precision may fall before the true one is looked at. Our choice, not tuned: the
// default tolerance takes one round. Another value costs or spares products, not accuracy.
constexpr double trusted_fall = 3e-5;

std::size_t at(Index row) { return 4 * static_cast<std::size_t>(row); }

// Scratch of the iteration in one precision; vectors have four numbers a row, the last row is the ground.
template <class Scalar>
struct Krylov {
  std::vector<Scalar> r, z, p, q, inverse;
  double rz = 0.0;

  void resize(Index rows) {
    for (auto* v : {&r, &z, &p, &q}) v->resize(at(rows + 1));
    std::fill_n(p.begin() + at(rows), 4, Scalar{0});
    inverse.resize(3 * at(rows));
  }
};

class Pcg final : public LinearSolver {
 public:
  explicit Pcg(const LinearOptions& options) : options_(options) {}

  LinearReport solve(const Team& team, const LinearSystem& system, const Points& b, Points& x) override {
    check_system(system, b, x);
    system_ = &system;
    team_ = team;
    prepare();
    const double start_norm = start(b, x);
    const LinearReport report = iterate(b, start_norm);
    finish(x);
    return report;
  }

 private:
  const RowLayout& layout() const { return *system_->layout; }

  // Calls body(block, begin, end) on the owned blocks, every thread on a range of them.
  template <class Body>
  void over_blocks(Body&& body) {
    const OwnedBlocks owned = owned_blocks(layout());
    const Index end_row = layout().end(), n = owned.last - owned.first;
    const Index share = std::max(least_blocks_a_thread, (n + team_.threads - 1) / team_.threads);
    parallel_ranges(team_, n, share, [&](Index first, Index last) {
      for (Index i = first; i < last; ++i) {
        const Index block = owned.first + i, begin = block * rows_per_block;
        body(block, begin, std::min<Index>(end_row, begin + rows_per_block));
      }
    });
  }

  // Sum of body(block range) over all rows of all ranks.
  template <class Body>
  double sum_over_blocks(Body&& body) {
    over_blocks([&](Index block, Index begin, Index end) { sums_[block] = body(begin, end); });
    return layout().ordered_sum(sums_);
  }

  // Rows of others that the product needs; forces of the terms.
  template <class Scalar>
  void refresh(Scalar* v) {
    layout().exchange(halo_, v, 4);
    if (!terms_.empty()) terms_.evaluate(team_, v);
  }

  void multiply(Index begin, Index end, const double* x, double* y) const {
    multiply_system(*system_, terms_, begin, end, x, y);
  }
  void multiply(Index begin, Index end, const float* x, float* y) const {
    matrix_.multiply(begin, end, x, y);
    if (terms_.empty()) return;
    for (Index row = begin; row < end; ++row)
      if (terms_.touches(row)) terms_.add(row, y + at(row));
  }

  template <class Scalar>
  void zero_fixed_rows(Index begin, Index end, Scalar* v) const {
    if (system_->fixed == nullptr) return;
    for (Index row = begin; row < end; ++row)
      if (is_fixed(*system_, row)) std::fill_n(v + at(row), 4, Scalar{0});
  }

  // Scratch, lists of the terms, matrix in single precision, inverse diagonal blocks (zero where a row is fixed).
  void prepare() {
    const Index rows = layout().n_rows();
    x_.resize(at(rows));
    residual_.resize(at(rows));
    single_.resize(rows);
    sums_.assign((rows + rows_per_block - 1) / rows_per_block, 0.0);
    bad_rows_.assign(sums_.size(), -1);
    terms_.build(system_->terms, system_->term_scale, layout());
    if (!layout().single())
      halo_ = with_term_rows(system_->halo ? *system_->halo : matrix_halo(*system_->matrix, layout()),
                             system_->terms ? *system_->terms : ExtraTerms{}, layout());
    matrix_.resize(*system_);
    over_blocks([&](Index block, Index begin, Index end) {
      for (Index row = begin; row < end; ++row) {
        matrix_.set_row(*system_, row);
        if (!set_inverse(row) && bad_rows_[block] < 0) bad_rows_[block] = row;
      }
    });
    Index bad_row = -1;
    for (std::size_t i = bad_rows_.size(); i-- > 0;)
      if (bad_rows_[i] >= 0) bad_row = bad_rows_[i];
    refuse_indefinite_row(*system_, bad_row);
  }

  bool set_inverse(Index row) {
    float* out = single_.inverse.data() + 3 * at(row);
    std::fill_n(out, 12, 0.0f);
    if (is_fixed(*system_, row)) return true;
    Mat3 inverse;
    if (!invert_positive_definite(diagonal_block(*system_, terms_, row), inverse)) return false;
    // More than rounding to single precision takes away: what is stored is positive definite too.
    inverse += 0x1p-22 * inverse.trace() * Mat3::Identity();
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) out[4 * c + r] = static_cast<float>(inverse(r, c));
    return true;
  }

  // residual_ = b - A x_, zero on fixed rows; returns sqrt(r . P^-1 r).
  double true_residual(const Points& b, bool x_is_zero) {
    if (!x_is_zero) refresh(x_.data());
    return std::sqrt(sum_over_blocks([&](Index begin, Index end) {
      double sum = 0.0;
      if (!x_is_zero) multiply(begin, end, x_.data(), residual_.data());
      for (Index row = begin; row < end; ++row) {
        double* r = residual_.data() + at(row);
        for (int d = 0; d < 3; ++d) r[d] = x_is_zero ? b(row, d) : b(row, d) - r[d];
        r[3] = 0.0;
        if (is_fixed(*system_, row)) r[0] = r[1] = r[2] = 0.0;
        const float* m = single_.inverse.data() + 3 * at(row);
        for (int d = 0; d < 3; ++d)
          sum += r[d] * (m[d] * r[0] + m[4 + d] * r[1] + m[8 + d] * r[2]);
      }
      return sum;
    }));
  }

  // With x the fixed rows alone the norm of the residual is what residuals are measured by. Then the guess is tried.
  double start(const Points& b, const Points& guess) {
    bool any_fixed = false, any_guess = false;
    for (Index row = layout().begin(); row < layout().end(); ++row)
      (is_fixed(*system_, row) ? any_fixed : any_guess) |= !guess.row(row).isZero(0.0);
    any_fixed = layout().communicator().maximum(any_fixed) > 0;
    any_guess = layout().communicator().maximum(any_guess) > 0;
    const auto set_x = [&](bool free_rows) {
      over_blocks([&](Index, Index begin, Index end) {
        for (Index row = begin; row < end; ++row) {
          const bool taken = free_rows || is_fixed(*system_, row);
          for (int d = 0; d < 3; ++d) x_[at(row) + d] = taken ? guess(row, d) : 0.0;
          x_[at(row) + 3] = 0.0;
        }
      });
    };
    set_x(false);
    b_norm_ = true_residual(b, !any_fixed);
    if (!std::isfinite(b_norm_)) throw_not_finite(*system_, b, guess);
    if (!any_guess) return b_norm_;
    set_x(true);
    const double guess_norm = true_residual(b, false);
    if (std::isfinite(guess_norm) && guess_norm < b_norm_) return guess_norm;
    set_x(false);
    return true_residual(b, !any_fixed);
  }

  LinearReport iterate(const Points& b, double norm) {
    LinearReport report;
    if (b_norm_ == 0.0) return report;  // x = 0 on free rows is exact
    const double goal = options_.tolerance * b_norm_;
    bool in_double = false, restart = true;
    while (norm > goal && report.iterations < options_.max_iterations) {
      const double before = norm;
      // A little below the goal, so that drift does not make another round of it.
      const double reach = in_double ? goal : std::max(0.97 * goal, trusted_fall * norm);
      const double iterated = in_double ? run(double_, restart, reach, report.iterations)
                                        : run(single_, restart, reach, report.iterations);
      norm = true_residual(b, false);
      if (in_double && !(norm < 0.5 * before)) break;  // rounding of double precision
      restart = !(norm < 2.0 * iterated);              // else directions stay conjugate
      if (!in_double && !(norm < 0.1 * before) && norm > goal && report.iterations < options_.max_iterations) {
        in_double = restart = true;
        double_.resize(layout().n_rows());
        over_blocks([&](Index, Index begin, Index end) {
          std::copy(single_.inverse.begin() + 3 * at(begin), single_.inverse.begin() + 3 * at(end),
                    double_.inverse.begin() + 3 * at(begin));
        });
      }
    }
    report.residual = norm / b_norm_;
    report.converged = norm <= goal;
    return report;
  }

  // Iterates from residual_, scaled by 1 / b_norm_ (no power of which single precision could lose), until the iterated
  // norm is below `reach`; returns it. Single precision gives up where the matrix looks indefinite to it.
  template <class Scalar>
  double run(Krylov<Scalar>& k, bool restart, double reach, int& iterations) {
    const double old_rz = k.rz, scale = 1.0 / b_norm_;
    k.rz = sum_over_blocks([&](Index begin, Index end) {
      for (std::size_t i = at(begin); i < at(end); ++i) k.r[i] = static_cast<Scalar>(scale * residual_[i]);
      return pcg::precondition(begin, end, k.inverse.data(), k.r.data(), k.z.data());
    });
    if (restart) std::fill(k.p.begin(), k.p.end(), Scalar{0});
    double beta = restart ? 0.0 : k.rz / old_rz, norm = std::sqrt(k.rz);
    while (norm > scale * reach && iterations < options_.max_iterations) {
      over_blocks([&](Index, Index begin, Index end) {
        pcg::update_direction(begin, end, static_cast<Scalar>(beta), k.z.data(), k.p.data());
      });
      refresh(k.p.data());
      const double curvature = sum_over_blocks([&](Index begin, Index end) {
        multiply(begin, end, k.p.data(), k.q.data());
        zero_fixed_rows(begin, end, k.q.data());
        return pcg::dot(begin, end, k.p.data(), k.q.data());
      });
      if (!(curvature > 0.0) || !std::isfinite(curvature)) {
        if (std::is_same_v<Scalar, double>) throw_indefinite("pcg", iterations + 1);
        break;
      }
      const Scalar alpha = static_cast<Scalar>(k.rz / curvature);
      const double rz = sum_over_blocks([&](Index begin, Index end) {
        return pcg::take_step(begin, end, alpha, b_norm_, k.p.data(), k.q.data(), k.inverse.data(), x_.data(), k.r.data(),
                              k.z.data());
      });
      beta = rz / k.rz;
      k.rz = rz;
      norm = std::sqrt(rz);
      ++iterations;
    }
    return norm * b_norm_;
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
  // Scratch of one solve; vectors have four numbers a row.
  const LinearSystem* system_ = nullptr;
  Team team_;
  TermRows terms_;
  Halo halo_;
  SingleMatrix matrix_;
  Krylov<float> single_;
  Krylov<double> double_;
  std::vector<double> x_, residual_, sums_;
  std::vector<Index> bad_rows_;
  double b_norm_ = 0.0;
};

}  // namespace

std::unique_ptr<LinearSolver> make_pcg(const LinearOptions& options) { return std::make_unique<Pcg>(options); }

}  // namespace loomstone
