// Fully nonlinear backward Euler and implicit midpoint (2.54, 2.55) by Newton's method with a line
// search on the residual
//   r(v+) = M (v+ - v) - h (f_ext + f(x_e, v_e)),
// backward Euler: x_e = x + h v+, v_e = v+; midpoint: x_e = x + h/4 (v + v+), v_e = (v + v+)/2.
// Contact pairs and anchors are those of the start of the step, their forces those at x_e.
#include <algorithm>
#include <cmath>
#include <sstream>

#include "core/base/error.h"
#include "core/integration/schemes.h"
#include "core/integration/step_solve.h"

namespace loomstone {

namespace {

// A step is roughly known when the residual has fallen to this part of the first guess's.
constexpr double roughly_known = 0.1;
// A residual is taken for progress if it is the least yet by this factor; else the potential has to
// fall.
constexpr double least_gain = 0.9;

class NewtonIntegrator final : public Integrator {
 public:
  NewtonIntegrator(bool midpoint, const IntegratorOptions& options, const ClothModel& model,
                   Elasticity& elasticity)
      : midpoint_(midpoint),
        options_(options),
        model_(model),
        elasticity_(elasticity),
        // Newton corrects what the inner solve leaves; its tolerance only sets the rate.
        solver_(
            {options.linear_solver, std::min(options.tolerance, 1e-4), options.max_iterations}) {}

  bool implicit() const override { return true; }
  bool asks_energy() const override { return true; }

  IntegrationReport advance(const Team& team, const RowLayout& layout, const StepInputs& given,
                            ClothState& state, Points& body_velocity) override {
    const Index n = model_.n_vertices, rows = layout.n_rows();
    StepInputs inputs = given;
    const double h = inputs.step;
    const BodyRows body_rows =
        midpoint_ ? BodyRows(h, h, h * h / 4, h / 2) : BodyRows(h, h, h * h, h);
    body_mass_ = body_rows.masses(given.body_mass);
    inputs.body_mass = &body_mass_;
    begin_step(team, layout, inputs, state, body_velocity);
    IntegrationReport report;
    report.newton_iterations = 0;
    const double scale =
        first_guess(team, layout, inputs) + h * norm(team, layout, inputs, load_, n);
    report.newton_residuals.push_back(scale > 0.0 ? now_.norm / scale : 0.0);
    best_ = now_.norm;
    const double tolerance = options_.newton_tolerance * scale;
    // Friction is limited by the normal forces of the start, and once the step is roughly known by
    // those found.
    bool new_limits = inputs.terms_at && !inputs.terms->empty();
    const double rough = std::max(tolerance, roughly_known * now_.norm);
    while (now_.norm > tolerance || new_limits) {
      if (new_limits && now_.norm <= rough) {
        evaluate(team, layout, inputs, now_, TermRequest::NewLimits);
        best_ = now_.norm;
        new_limits = false;
        continue;
      }
      if (report.newton_iterations == options_.max_newton_iterations)
        fail("did not converge", layout, report, inputs);
      if (!iterate(team, layout, inputs, report))
        fail("found no step that lowers residual or potential", layout, report, inputs);
      ++report.newton_iterations;
      report.newton_residuals.push_back(now_.norm / scale);
    }
    report.residual = scale > 0.0 ? now_.norm / scale : 0.0;

    const double weight = midpoint_ ? h / 2 : h;
    parallel_for(team, n, [&](Index i) {
      const Vec3 v1 = now_.velocity.row(i);
      const Vec3 sum = midpoint_ ? Vec3(v1 + state.v.row(i).transpose()) : v1;
      state.x.row(i) += weight * sum.transpose();
      state.v.row(i) = v1;
    });
    place_fixed(inputs, state.x);
    body_velocity +=
        body_rows.velocity_share * (now_.velocity.bottomRows(rows - n) - body_velocity);
    return report;
  }

 private:
  // A velocity at the end of the step and what follows from it.
  struct Iterate {
    Points velocity, residual;
    ExtraTerms terms;
    double norm = 0.0;  // of the residual
    double term_energy = 0.0;
    double potential = NAN;  // found when asked for
  };

  void begin_step(const Team& team, const RowLayout& layout, const StepInputs& inputs,
                  const ClothState& state, const Points& body_velocity) {
    const Index n = model_.n_vertices, rows = layout.n_rows();
    start_x_ = state.x;
    start_velocity_.resize(rows, 3);
    start_velocity_.topRows(n) = state.v;
    start_velocity_.bottomRows(rows - n) = body_velocity;
    load_ = *inputs.force;
    elasticity_.add_explicit_bending(team, state.x, state.v, std::min(layout.begin(), n),
                                     std::min(layout.end(), n), load_);
    all_load_ = load_;
    if (!layout.single()) {
      all_load_.conservativeResize(rows, 3);
      layout.gather(all_load_.data(), 3);
    }
  }

  // Starts from going on as before or from standing still at x, whichever has the smaller residual
  // (contacts and taut cloth resist a ballistic step with any force). Returns that residual, by
  // which later ones are measured.
  double first_guess(const Team& team, const RowLayout& layout, const StepInputs& inputs) {
    now_.velocity = start_velocity_;
    trial_.velocity =
        midpoint_ ? Points(-start_velocity_) : Points(Points::Zero(start_velocity_.rows(), 3));
    for (Iterate* guess : {&now_, &trial_}) {
      cloth_ = guess->velocity.topRows(model_.n_vertices);
      prescribe_velocities(inputs, start_x_, cloth_);
      guess->velocity.topRows(model_.n_vertices) = cloth_;
      evaluate(team, layout, inputs, *guess);
    }
    if (trial_.norm < now_.norm) std::swap(now_, trial_);
    return now_.norm;
  }

  // One Newton step. The exact Jacobian converges quadratically where it is positive definite;
  // where cloth is about to buckle it is not, and its positive part leads downhill.
  bool iterate(const Team& team, const RowLayout& layout, const StepInputs& inputs,
               IntegrationReport& report) {
    const bool try_exact = options_.jacobian == "exact" || report.newton_iterations >= 2;
    if (try_exact && solve(team, layout, inputs, JacobianKind::Exact, report) &&
        search(team, layout, inputs, 0.1))
      return true;
    if (!solve(team, layout, inputs, JacobianKind::Positive, report) ||
        !search(team, layout, inputs, 1e-4))
      return false;
    if (try_exact) go_further(team, layout, inputs);
    return true;
  }

  // Accepts what makes the residual the least yet, or what lowers the potential whose gradient it
  // is: near buckling the residual has to grow on the way to the solution. Neither can go round in
  // circles. Our choice.
  bool search(const Team& team, const RowLayout& layout, const StepInputs& inputs, double least) {
    for (length_ = 1.0; length_ >= least; length_ /= 2) {
      trial_.velocity = now_.velocity + length_ * correction_;
      evaluate(team, layout, inputs, trial_);
      if (!(trial_.norm < least_gain * best_) &&
          !(potential(team, inputs, trial_) < potential(team, inputs, now_)))
        continue;
      best_ = std::min(best_, trial_.norm);
      std::swap(now_, trial_);  // trial_ keeps the point that was left
      return true;
    }
    return false;
  }

  // Beside a saddle of the potential the positive Jacobian is far too stiff along the unstable
  // mode, and every step would be as short: doubled while the potential falls.
  void go_further(const Team& team, const RowLayout& layout, const StepInputs& inputs) {
    if (length_ < 1.0) return;
    const Points origin = trial_.velocity;
    for (;;) {
      trial_.velocity = origin + 2 * length_ * correction_;
      evaluate(team, layout, inputs, trial_);
      if (!(potential(team, inputs, trial_) < potential(team, inputs, now_))) return;
      std::swap(now_, trial_);
      best_ = std::min(best_, now_.norm);
      length_ *= 2;
    }
  }

  [[noreturn]] void fail(const char* what, const RowLayout& layout, const IntegrationReport& report,
                         const StepInputs& inputs) {
    layout.gather(now_.residual.data(), 3);
    Index worst = 0;
    double largest = -1.0;
    for (Index i = 0; i < model_.n_vertices; ++i) {
      const double size =
          (*inputs.fixed)[i] ? 0.0 : now_.residual.row(i).squaredNorm() / model_.mass[i];
      if (size > largest) largest = size, worst = i;
    }
    std::ostringstream out;
    out << "the Newton loop of " << options_.method << ' ' << what << " ("
        << report.newton_iterations << " iterations, relative residual "
        << report.newton_residuals.back() << ", asked " << options_.newton_tolerance
        << "); shorten integrator.step or raise integrator.newton_tolerance";
    throw NewtonFailure(out.str(), worst);
  }

  // Norm in the metric M^-1 over free rows, the same bits on any number of ranks.
  double norm(const Team& team, const RowLayout& layout, const StepInputs& inputs, const Points& r,
              Index n_rows) {
    const Index n = model_.n_vertices;
    std::vector<double> sums((layout.n_rows() + rows_per_block - 1) / rows_per_block, 0.0);
    const Index first = layout.begin() / rows_per_block;
    const Index last = (layout.end() + rows_per_block - 1) / rows_per_block;
    parallel_for(
        team, last - first,
        [&](Index b) {
          const Index block = first + b;
          double sum = 0.0;
          for (Index i = block * rows_per_block;
               i < std::min<Index>(n_rows, (block + 1) * rows_per_block); ++i) {
            if ((*inputs.fixed)[i]) continue;
            sum += i < n
                       ? r.row(i).squaredNorm() / model_.mass[i]
                       : r.row(i).dot((*inputs.body_mass)[i - n].llt().solve(r.row(i).transpose()));
          }
          sums[block] = sum;
        },
        8);
    return std::sqrt(layout.ordered_sum(sums));
  }

  // Displacement at which forces are evaluated.
  Points displacement(double h, const Points& velocity) const {
    return midpoint_ ? Points(h / 4 * (start_velocity_ + velocity)) : Points(h * velocity);
  }

  // Terms and residual (owned rows) of the iterate's velocity.
  void evaluate(const Team& team, const RowLayout& layout, const StepInputs& inputs, Iterate& it,
                TermRequest request = TermRequest::Derivative) {
    const Index n = model_.n_vertices, rows = layout.n_rows();
    const Index begin = std::min(layout.begin(), n), end = std::min(layout.end(), n);
    const double h = inputs.step;
    const Points moved = displacement(h, it.velocity);
    x_ = start_x_ + moved.topRows(n);
    cloth_ = midpoint_ ? Points(0.5 * (start_velocity_ + it.velocity).topRows(n))
                       : Points(it.velocity.topRows(n));
    force_ = load_;
    elasticity_.add_implicit_forces(team, x_, &cloth_, begin, end, force_);
    it.residual = Points::Zero(rows, 3);
    parallel_for(team, end - begin, [&](Index i) {
      const Index row = begin + i;
      it.residual.row(row) = h * force_.row(row) -
                             model_.mass[row] * (it.velocity.row(row) - start_velocity_.row(row));
    });
    for (Index row = std::max(n, layout.begin()); row < layout.end(); ++row)
      it.residual.row(row) = -((*inputs.body_mass)[row - n] *
                               (it.velocity.row(row) - start_velocity_.row(row)).transpose())
                                  .transpose();
    if (inputs.terms) {
      const double time = midpoint_ ? h / 2 : h;
      it.terms = *inputs.terms;
      it.term_energy = inputs.terms_at ? (*inputs.terms_at)(moved, time, request, it.terms)
                                       : linear_terms_at(moved, time, it.terms);
      add_term_gradients(it.terms, layout, h, it.residual);
    }
    it.norm = norm(team, layout, inputs, it.residual, rows);
    it.potential = NAN;
  }

  static double linear_terms_at(const Points& moved, double time, ExtraTerms& terms) {
    double energy = 0.0;
    for (ExtraTerm& term : terms) energy += term.move_linearly(moved, time);
    return energy;
  }

  // 1/2 |v+ - v|_M^2 - h f_ext.v+ + c psi(x_e), c = 1 for backward Euler, 4 for midpoint: minus r
  // is its gradient where nothing is viscous. Over all rows on every rank; needed only when the
  // residual does not fall.
  double potential(const Team& team, const StepInputs& inputs, Iterate& it) {
    if (!std::isnan(it.potential)) return it.potential;
    const Index n = model_.n_vertices;
    const double h = inputs.step, c = midpoint_ ? 4.0 : 1.0;
    x_ = start_x_ + displacement(h, it.velocity).topRows(n);
    double sum = parallel_sum(team, n, [&](Index i) {
      const Vec3 change = (it.velocity.row(i) - start_velocity_.row(i)).transpose();
      return 0.5 * model_.mass[i] * change.squaredNorm() -
             h * all_load_.row(i).dot(it.velocity.row(i));
    });
    for (Index row = n; row < it.velocity.rows(); ++row) {
      const Vec3 change = (it.velocity.row(row) - start_velocity_.row(row)).transpose();
      sum += 0.5 * change.dot((*inputs.body_mass)[row - n] * change);
    }
    sum += c * elasticity_.membrane_energy(team, x_);
    if (elasticity_.implicit_bending()) sum += c * elasticity_.bending_energy(team, x_);
    if (inputs.terms) sum += c * it.term_energy;
    return it.potential = sum;
  }

  // The correction of now_; false where the exact Jacobian is found indefinite (the same on all
  // ranks).
  bool solve(const Team& team, const RowLayout& layout, const StepInputs& inputs, JacobianKind kind,
             IntegrationReport& report) {
    const Index n = model_.n_vertices, begin = std::min(layout.begin(), n),
                end = std::min(layout.end(), n);
    const double h = inputs.step, c_k = midpoint_ ? h * h / 4 : h * h, c_d = midpoint_ ? h / 2 : h;
    const Points moved = displacement(h, now_.velocity);
    x_ = start_x_ + moved.topRows(n);
    elasticity_.assemble(team, x_, {kind, {c_k, c_d}}, begin, end);
    StepInputs at_iterate = inputs;
    if (inputs.terms) at_iterate.terms = &now_.terms;
    if (inputs.terms_at && kind == JacobianKind::Positive) {
      secant_ = *inputs.terms;
      (*inputs.terms_at)(moved, midpoint_ ? h / 2 : h, TermRequest::Secant, secant_);
      at_iterate.terms = &secant_;
    }
    correction_ = Points::Zero(layout.n_rows(), 3);
    try {
      const LinearReport solved =
          solver_.solve(team, layout, at_iterate, elasticity_, c_k, now_.residual, correction_);
      report.linear_iterations += solved.iterations;
      return true;
    } catch (const SolverFailure&) {
      if (kind == JacobianKind::Exact) return false;
      throw;
    }
  }

  bool midpoint_;
  IntegratorOptions options_;
  const ClothModel& model_;
  Elasticity& elasticity_;
  StepSolve solver_;

  // Scratch of a step.
  std::vector<Mat3> body_mass_;
  Points start_x_, start_velocity_, load_, all_load_, correction_;
  Iterate now_, trial_;
  ExtraTerms secant_;
  double best_ = 0.0;    // least residual yet
  double length_ = 1.0;  // of the step last tried
  Points x_, cloth_, force_;
};

}  // namespace

std::unique_ptr<Integrator> make_newton(const IntegratorOptions& options, const ClothModel& model,
                                        Elasticity& elasticity) {
  return std::make_unique<NewtonIntegrator>(options.method == "nonlinear-midpoint", options, model,
                                            elasticity);
}

}  // namespace loomstone
