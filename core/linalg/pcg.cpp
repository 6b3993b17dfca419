// Conjugate gradients preconditioned by the diagonal blocks, with coarse levels added
// (aggregation_multigrid.h) or not, on threads and ranks, or by symmetric Gauss-Seidel, whose
// sweeps are sequential. Hestenes and Stiefel, J. Res. NBS 49 (1952). Three parallel regions an
// iteration, one more with extra terms; sums by blocks of rows, so the bits depend neither on
// threads nor on ranks. Eight rows are worked at once (sliced_ellpack.h).
//
// The product is bound by memory, so the iteration works in single precision, on couplings
// (coupling_matrix.h); the solution is summed in double precision, and the residual it really
// leaves, in double precision and the norm of the diagonal blocks, decides when to stop. Where that
// residual has drifted from the iterated one the iteration goes on from it [VanDerVorst2000]. What
// single precision cannot solve is solved in double precision.
#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/linalg/aggregation_multigrid.h"
#include "core/linalg/coupling_matrix.h"
#include "core/linalg/matrix_halo.h"
#include "core/linalg/pcg_kernels.h"
#include "core/linalg/solvers.h"
#include "core/linalg/symmetric_gauss_seidel.h"
#include "core/linalg/system.h"

namespace loomstone {

namespace {

constexpr Index least_blocks_a_thread = 4;  // 512 rows, about 5 us of work
// How far the iterated residual in single precision may fall before the true one is looked at. Our
// choice, not tuned: the default tolerance takes one round. Another value costs or spares products,
// not accuracy.
constexpr double trusted_fall = 3e-5;

std::size_t at(Index row) { return 4 * static_cast<std::size_t>(row); }
std::size_t in_slices(Index slice) { return 24 * static_cast<std::size_t>(slice); }

// Scratch of the iteration in one precision: r, z, q and the inverse diagonal blocks by slices, the
// direction p by rows (the last is that of empty lanes, and stays zero).
template <class Scalar>
struct Krylov {
  CouplingMatrix<Scalar> matrix;
  std::vector<Scalar> r, z, p, q, inverse;
  double rz = 0.0, last_rz = 0.0;  // r . z, and before the last step
  double beta = 0.0;               // of the next direction
  double norm = 0.0;               // sqrt(r . P^-1 r), P the diagonal blocks

  void resize(const SlicedEllpack& slices) {
    matrix.resize(slices);
    for (auto* v : {&r, &z, &q}) v->resize(in_slices(slices.n_slices()));
    p.resize(at(slices.n_rows() + 1));
    std::fill_n(p.begin() + at(slices.n_rows()), 4, Scalar{0});
    inverse.resize(2 * in_slices(slices.n_slices()));
  }
};

enum class Preconditioner { Levels, Jacobi, GaussSeidel };

class Pcg final : public LinearSolver {
 public:
  Pcg(const LinearOptions& options, Preconditioner preconditioner)
      : options_(options),
        levels_(preconditioner == Preconditioner::Levels),
        gauss_seidel_(preconditioner == Preconditioner::GaussSeidel) {}

  LinearReport solve(const Team& team, const LinearSystem& system, const Points& b,
                     Points& x) override {
    if (gauss_seidel_ && !system.layout->single())
      throw Unsupported("the linear solver \"gauss-seidel\" runs on one rank, got " +
                        std::to_string(system.layout->communicator().size()) +
                        " ranks; use \"pcg\"");
    check_system(system, b, x);
    system_ = &system;
    team_ = team;
    const bool goes_on = system.same_system && left_iteration_;
    if (!goes_on) prepare();
    const double norm = goes_on ? single_.norm * b_norm_ : start(b, x);
    const LinearReport report = iterate(b, norm, goes_on);
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

  // The same on slices: body(first slice, last slice).
  template <class Body>
  double sum_over_slices(Body&& body) {
    return sum_over_blocks([&](Index begin, Index end) {
      return body(SlicedEllpack::first_slice(begin), SlicedEllpack::last_slice(end));
    });
  }

  // Where the first of a row's three numbers lies in vectors by slices; the next are 8 further
  // each.
  std::size_t place_of(Index row) const {
    return in_slices(slices_.place[row] / 8) + slices_.place[row] % 8;
  }
  // Writes a row of such a vector: value(place, axis).
  template <class Value>
  void set_row(Index row, std::vector<double>& v, Value&& value) const {
    const std::size_t place = place_of(row);
    for (int d = 0; d < 3; ++d) v[place + 8 * d] = value(place + 8 * d, d);
  }

  // q = A p on rows [begin, end); returns p . q.
  template <class Scalar>
  double multiply(Index begin, Index end, Krylov<Scalar>& k) {
    double product = k.matrix.multiply(slices_, SlicedEllpack::first_slice(begin),
                                       SlicedEllpack::last_slice(end), k.p.data(), k.q.data());
    if (terms_.empty()) return product;
    terms_.for_touched(begin, end, [&](Index row) {
      const Vec3 force = terms_.force(row);
      Scalar* q = k.q.data() + place_of(row);
      for (int d = 0; d < 3; ++d) {
        q[8 * d] += static_cast<Scalar>(force[d]);
        product += static_cast<double>(k.p[at(row) + d]) * force[d];
      }
    });
    return product;
  }

  // Scratch, lists of the terms, matrix in single precision, inverse diagonal blocks (zero where a
  // row is fixed). A solve with the same matrix takes the preconditioner of the one before:
  // friction alone has changed, and to make it anew would cost more than the iterations that spares
  // (stack 0.84, fold 0.78 of the time, 1.1 and 0.94 of the iterations).
  void prepare() {
    const Index rows = layout().n_rows();
    const bool laid_out = !system_->same_matrix && slices_.set_pattern(system_->matrix, rows);
    levels_laid_out_ = levels_laid_out_ && !laid_out;
    if (!system_->same_matrix) levels_on_ = levels_ && n_cloth_rows(*system_) > 0;
    x_.resize(at(rows + 1));
    product_.resize(at(rows));
    residual_.resize(in_slices(slices_.n_slices()));
    if (!system_->same_matrix) single_.resize(slices_);
    sums_.assign((rows + rows_per_block - 1) / rows_per_block, 0.0);
    bad_rows_.assign(sums_.size(), rows);
    seen_.assign(sums_.size(), 0);
    terms_.build(system_->terms, system_->term_scale, layout());
    if (!layout().single())
      halo_ =
          with_term_rows(system_->halo ? *system_->halo : matrix_halo(*system_->matrix, layout()),
                         system_->terms ? *system_->terms : ExtraTerms{}, layout());
    if (system_->same_matrix && !gauss_seidel_) return;
    over_blocks([&](Index block, Index begin, Index end) {
      const Index first = SlicedEllpack::first_slice(begin), last = SlicedEllpack::last_slice(end);
      if (!system_->same_matrix)
        single_.matrix.set_slices(system_->matrix, system_->body_blocks, slices_, first, last);
      for (Index slice = first; slice < last; ++slice)
        bad_rows_[block] = std::min(bad_rows_[block], set_inverse(slice));
    });
    const Index bad_row = *std::min_element(bad_rows_.begin(), bad_rows_.end());
    refuse_indefinite_row(*system_, bad_row < rows ? bad_row : -1);
    if (gauss_seidel_) sweeps_.prepare(*system_, slices_, single_.inverse);
    if (levels_on_) prepare_levels();
  }

  void prepare_levels() {
    if (!levels_laid_out_) coarse_.set_pattern(*system_->matrix);
    levels_laid_out_ = true;
    coarse_.prepare(team_, *system_);
    levels_on_ = coarse_.usable();
    slots_.resize(slices_.rows.size());
    for (std::size_t place = 0; place < slots_.size(); ++place) {
      const Index row = slices_.rows[place];
      slots_[place] = row < slices_.n_rows()
                          ? coarse_.slot(row)
                          : coarse_.unused_slot(static_cast<Index>(place) / rows_per_block);
    }
  }

  // Inverse diagonal blocks of a slice; the first of its rows whose block is not positive definite,
  // or the number of rows.
  Index set_inverse(Index slice) {
    const Index* rows = slices_.rows.data() + 8 * static_cast<std::size_t>(slice);
    const auto is_free = [&](Index row) {
      return row < slices_.n_rows() && !is_fixed(*system_, row);
    };
    alignas(64) double blocks[48];
    for (int l = 0; l < 8; ++l) {
      const Mat3 block =
          is_free(rows[l]) ? diagonal_block(*system_, terms_, rows[l]) : Mat3(Mat3::Identity());
      const double upper[6] = {block(0, 0), block(0, 1), block(0, 2),
                               block(1, 1), block(1, 2), block(2, 2)};
      for (int e = 0; e < 6; ++e) blocks[8 * e + l] = upper[e];
    }
    const unsigned bad = pcg::invert(blocks);
    float* out = single_.inverse.data() + 2 * in_slices(slice);
    Index first_bad = slices_.n_rows();
    for (int l = 0; l < 8; ++l) {
      if (bad >> l & 1) first_bad = std::min(first_bad, rows[l]);
      // More than rounding to single precision takes away: what is stored is positive definite too.
      const double more = 0x1p-22 * (blocks[l] + blocks[24 + l] + blocks[40 + l]);
      for (const int e : {0, 3, 5}) blocks[8 * e + l] += more;
      for (int e = 0; e < 6; ++e)
        out[8 * e + l] = is_free(rows[l]) ? static_cast<float>(blocks[8 * e + l]) : 0.0f;
    }
    return first_bad;
  }

  // residual_ = b - A x_, zero on fixed rows; returns sqrt(r . P^-1 r).
  double true_residual(const Points& b, bool x_is_zero) {
    if (!x_is_zero) refresh(x_.data());
    return std::sqrt(sum_over_blocks([&](Index begin, Index end) {
      if (!x_is_zero) multiply_system(*system_, terms_, begin, end, x_.data(), product_.data());
      for (Index row = begin; row < end; ++row) {
        const bool fixed = is_fixed(*system_, row);
        set_row(row, residual_, [&](std::size_t, int d) {
          return fixed ? 0.0 : x_is_zero ? b(row, d) : b(row, d) - product_[at(row) + d];
        });
      }
      return pcg::preconditioned_square(SlicedEllpack::first_slice(begin),
                                        SlicedEllpack::last_slice(end), single_.inverse.data(),
                                        residual_.data());
    }));
  }

  // residual_ = b - A x_ as true_residual() has it, where the last solve has left x_ and its
  // residual, and only b and the terms are others: to single precision, as the iteration it starts.
  double known_residual(const Points& b) {
    refresh(x_.data());
    return std::sqrt(sum_over_blocks([&](Index begin, Index end) {
      for (Index row = begin; row < end; ++row) {
        const bool fixed = is_fixed(*system_, row);
        set_row(row, residual_, [&](std::size_t i, int d) {
          return fixed ? 0.0 : b(row, d) - product_of_matrix_[i];
        });
      }
      terms_.for_touched(begin, end, [&](Index row) {
        if (is_fixed(*system_, row)) return;
        const Vec3 force = terms_.force(row);
        set_row(row, residual_, [&](std::size_t i, int d) { return residual_[i] - force[d]; });
      });
      return pcg::preconditioned_square(SlicedEllpack::first_slice(begin),
                                        SlicedEllpack::last_slice(end), single_.inverse.data(),
                                        residual_.data());
    }));
  }

  // What a rough solve leaves for one with the same matrix: x_, and the product of the matrix with
  // it, terms apart.
  void leave(const Points& b) {
    refresh(x_.data());
    product_of_matrix_.resize(residual_.size());
    over_blocks([&](Index, Index begin, Index end) {
      for (Index row = begin; row < end; ++row)
        set_row(row, product_of_matrix_, [&](std::size_t i, int d) {
          return b(row, d) - b_norm_ * static_cast<double>(single_.r[i]);
        });
      terms_.for_touched(begin, end, [&](Index row) {
        const Vec3 force = terms_.force(row);
        set_row(row, product_of_matrix_,
                [&](std::size_t i, int d) { return product_of_matrix_[i] - force[d]; });
      });
    });
    left_iteration_ = true;
  }

  // With x the fixed rows alone the norm of the residual is what residuals are measured by. Then
  // the guess is tried.
  double start(const Points& b, const Points& guess) {
    const bool stays = system_->same_matrix && left_iteration_;
    enum {
      Fixed = 1,
      Free = 2,
      Other = 4
    };  // rows that are fixed and not zero, free and not zero, not what x_ is
    over_blocks([&](Index block, Index begin, Index end) {
      int seen = 0;
      for (Index row = begin; row < end; ++row) {
        if (!guess.row(row).isZero(0.0)) seen |= is_fixed(*system_, row) ? Fixed : Free;
        if (stays && guess.row(row).transpose() != Eigen::Map<const Vec3>(x_.data() + at(row)))
          seen |= Other;
      }
      seen_[block] = static_cast<std::uint8_t>(seen);
    });
    const auto any = [&](int what) {
      const bool mine = std::any_of(seen_.begin(), seen_.end(),
                                    [&](std::uint8_t seen) { return (seen & what) != 0; });
      return layout().communicator().maximum(mine) > 0;
    };
    const bool any_fixed = any(Fixed), any_guess = any(Free), known = stays && !any(Other);
    left_iteration_ = false;
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
    const double guess_norm = known ? known_residual(b) : true_residual(b, false);
    if (std::isfinite(guess_norm) && guess_norm < b_norm_) return guess_norm;
    set_x(false);
    return true_residual(b, !any_fixed);
  }

  LinearReport iterate(const Points& b, double norm, bool goes_on) {
    LinearReport report;
    left_iteration_ = false;
    if (b_norm_ == 0.0) return report;  // x = 0 on free rows is exact
    const double goal =
        (system_->tolerance > 0.0 ? system_->tolerance : options_.tolerance) * b_norm_;
    const bool rough = system_->tolerance > options_.tolerance;
    bool in_double = false;
    Run way = goes_on ? Run::On : Run::Anew;
    while (norm > goal && report.iterations < options_.max_iterations) {
      const double before = norm;
      // A little below the goal, so that drift does not make another round of it.
      const double reach = in_double ? goal : std::max(0.97 * goal, trusted_fall * norm);
      const double iterated = in_double ? run(double_, way, reach, report.iterations)
                                        : run(single_, way, reach, report.iterations);
      if (rough && iterated <= goal) {  // no look at the true one: what comes next starts with it
        report.residual = iterated / b_norm_;
        if (!in_double) leave(b);
        return report;
      }
      norm = true_residual(b, false);
      if (in_double && !(norm < 0.5 * before)) break;  // rounding of double precision
      way = norm < 2.0 * iterated ? Run::Conjugate : Run::Anew;
      if (!in_double && !(norm < 0.1 * before) && norm > goal &&
          report.iterations < options_.max_iterations) {
        in_double = true;
        way = Run::Anew;
        prepare_double();
      }
    }
    report.residual = norm / b_norm_;
    report.converged = norm <= goal;
    return report;
  }

  void prepare_double() {
    double_.resize(slices_);
    over_blocks([&](Index, Index begin, Index end) {
      const Index first = SlicedEllpack::first_slice(begin), last = SlicedEllpack::last_slice(end);
      double_.matrix.set_slices(system_->matrix, system_->body_blocks, slices_, first, last);
      std::copy(single_.inverse.begin() + 2 * in_slices(first),
                single_.inverse.begin() + 2 * in_slices(last),
                double_.inverse.begin() + 2 * in_slices(first));
    });
  }

  // Sums of residuals for the coarse levels; the slices are those of one block.
  template <class Scalar>
  void add_up(Index first, Index last, const Krylov<Scalar>& k) {
    if (!levels_on_) return;
    coarse_.clear_residual(8 * first / rows_per_block);
    pcg::add_up(first, last, slots_.data(), k.r.data(), coarse_.residual());
  }

  // r . z with z = P^-1 r; `square` is that of the diagonal blocks.
  template <class Scalar>
  double residual_product(double square, Krylov<Scalar>& k) {
    if (gauss_seidel_) return sweeps_.apply(k.r, k.z);
    if (!levels_on_) return square;
    const double product = coarse_.solve(team_, layout());
    levels_on_ = product >= 0.0;  // a cycle that is not definite is no preconditioner
    return levels_on_ ? square + product : square;
  }

  // From residual_, in new directions or in such that are conjugate to the last; or as if the last
  // run had not ended.
  enum class Run { Anew, Conjugate, On };

  template <class Scalar>
  void begin_run(Krylov<Scalar>& k, bool conjugate) {
    const double scale = 1.0 / b_norm_;
    const double square = sum_over_slices([&](Index first, Index last) {
      for (std::size_t i = in_slices(first); i < in_slices(last); ++i)
        k.r[i] = static_cast<Scalar>(scale * residual_[i]);
      add_up(first, last, k);
      return pcg::precondition(first, last, k.inverse.data(), k.r.data(), k.z.data());
    });
    k.norm = std::sqrt(square);
    const double rz = residual_product(square, k);
    k.beta = conjugate ? rz / k.last_rz : 0.0;
    k.rz = rz;
    if (!conjugate) std::fill(k.p.begin(), k.p.end(), Scalar{0});
  }

  // Iterates, with all scaled by 1 / b_norm_ (no power of which single precision could lose), until
  // the iterated norm is below `reach`; returns it. Single precision gives up where the matrix
  // looks indefinite to it.
  template <class Scalar>
  double run(Krylov<Scalar>& k, Run way, double reach, int& iterations) {
    if (way != Run::On) begin_run(k, way == Run::Conjugate);
    double length = 0.0;  // of the last step along p, which x takes when p changes
    while (k.norm * b_norm_ > reach && iterations < options_.max_iterations) {
      over_blocks([&](Index, Index begin, Index end) {
        pcg::update_direction(SlicedEllpack::first_slice(begin), SlicedEllpack::last_slice(end),
                              {slices_.rows.data(), slots_.data()}, length,
                              static_cast<Scalar>(k.beta), k.z.data(),
                              levels_on_ ? coarse_.correction() : nullptr, k.p.data(), x_.data());
      });
      length = 0.0;
      refresh(k.p.data());
      const double curvature =
          sum_over_blocks([&](Index begin, Index end) { return multiply(begin, end, k); });
      if (!(curvature > 0.0) || !std::isfinite(curvature)) {
        if (std::is_same_v<Scalar, double>)
          throw_indefinite(gauss_seidel_ ? "gauss-seidel" : "pcg", iterations + 1);
        break;
      }
      const Scalar alpha = static_cast<Scalar>(k.rz / curvature);
      const double next_square = sum_over_slices([&](Index first, Index last) {
        const double sum = pcg::take_step(first, last, alpha, k.q.data(), k.inverse.data(),
                                          k.r.data(), k.z.data());
        add_up(first, last, k);
        return sum;
      });
      const bool had_levels = levels_on_;
      const double rz = residual_product(next_square, k);
      length = b_norm_ * static_cast<double>(alpha);
      k.beta = had_levels == levels_on_ ? rz / k.rz : 0.0;
      k.last_rz = k.rz;
      k.rz = rz;
      k.norm = std::sqrt(next_square);
      ++iterations;
    }
    over_blocks([&](Index, Index begin, Index end) {
      pcg::move(begin, end, length, k.p.data(), x_.data());
    });
    return k.norm * b_norm_;
  }

  void finish(Points& x) {
    over_blocks([&](Index, Index begin, Index end) {
      for (Index row = begin; row < end; ++row)
        if (!is_fixed(*system_, row))
          x.row(row) = Eigen::Map<const Vec3>(x_.data() + at(row)).transpose();
    });
    layout().gather(x.data(), 3);
    system_ = nullptr;
  }

  LinearOptions options_;
  bool levels_, gauss_seidel_;
  // Scratch of one solve; x_ and product_ have four numbers a row (x_ one more row, of
  // empty lanes), residual_ lies in slices.
  const LinearSystem* system_ = nullptr;
  Team team_;
  TermRows terms_;
  Halo halo_;
  SlicedEllpack slices_;
  SymmetricGaussSeidel sweeps_;
  AggregationMultigrid coarse_;
  std::vector<Index> slots_;      // (slices x 8) of coarse_
  bool levels_laid_out_ = false;  // for the pattern of slices_
  bool levels_on_ = false;        // in this solve
  Krylov<float> single_;
  Krylov<double> double_;
  std::vector<double> x_, product_, residual_, sums_;
  std::vector<std::uint8_t> seen_;  // (blocks)
  bool left_iteration_ =
      false;  // by the last solve, for the next: x_, directions, product_of_matrix_
  std::vector<double>
      product_of_matrix_;  // (slices x 3 x 8) with x_, terms apart; where something is left
  std::vector<Index> bad_rows_;
  double b_norm_ = 0.0;
};

}  // namespace

std::unique_ptr<LinearSolver> make_pcg(const LinearOptions& options) {
  return std::make_unique<Pcg>(options, Preconditioner::Levels);
}
std::unique_ptr<LinearSolver> make_block_jacobi(const LinearOptions& options) {
  return std::make_unique<Pcg>(options, Preconditioner::Jacobi);
}
std::unique_ptr<LinearSolver> make_gauss_seidel(const LinearOptions& options) {
  return std::make_unique<Pcg>(options, Preconditioner::GaussSeidel);
}

}  // namespace loomstone
