// Fully nonlinear backward Euler, and implicit midpoint ((2.54), (2.55) of [Thomaszewski2010]),
// solved by Newton's method with a line search. The residual is
//   r(v+) = M (v+ - v) - h (f_ext + f(x_e, v_e)),
// where f_ext are the loads and explicit bending forces, and f are all other forces.
// Backward Euler: x_e = x + h v+, v_e = v+. Midpoint: x_e = x + h/4 (v + v+), v_e = (v + v+)/2.
// Contact pairs and friction anchors are those at the start of the step; contact forces are
// evaluated at x_e.
#include <algorithm>
#include <cmath>

#include "core/base/message.h"
#include "core/integration/explicit_bending.h"
#include "core/integration/integrator_factories.h"
#include "core/integration/scheme_coefficients.h"
#include "core/integration/step_solve.h"

namespace loomstone {

namespace {

// The friction limit of a contact is the friction coefficient times the normal force. The limits
// are first updated when the residual has fallen to the fraction `roughly_known` of its initial
// value or to the tolerance, whichever is larger. If the residual after an update exceeds
// `limit_tolerance` times its scale (see iterate_to_tolerance()), another update follows when the
// residual has fallen to the tolerance. A residual that is accepted as a rounding error (see
// rounding_tolerance) counts as having fallen far enough. There are at most `most_updates` updates.
constexpr double roughly_known = 0.1, limit_tolerance = 0.02;
constexpr int most_updates = 8;
// search() accepts a Newton step if its residual is below this fraction of the smallest residual
// since the last update of the friction limits. Otherwise, it accepts the step only if this lowers
// the potential.
constexpr double least_gain = 0.9;
// If iterate() takes no Newton step, the residual is accepted if both the residual and
// `default_tolerance` times its scale (see iterate_to_tolerance()) are at most `rounding_tolerance`
// times its rounding_error(). Our choice: the residuals in such cases are one to three times this
// error.
constexpr double rounding_tolerance = 10.0, default_tolerance = 1e-6;

class NewtonIntegrator final : public Integrator {
 public:
  NewtonIntegrator(Scheme scheme, std::string_view name, const NewtonOptions& options,
                   const ClothModel& model, Elasticity& elasticity)
      : midpoint_(scheme == Scheme::Midpoint),
        scheme_(scheme),
        bending_(scheme == Scheme::Midpoint),
        name_(name),
        options_(options),
        model_(model),
        elasticity_(elasticity),
        // The tolerance of the linear solve only affects the rate of convergence.
        solver_(
            {options.linear_solver, std::min(options.tolerance, 1e-4), options.max_iterations}) {}

  bool implicit() const override { return true; }
  bool damps() const override { return scheme_ == Scheme::BackwardEuler; }
  double time_of_forces() const override { return midpoint_ ? 0.5 : 1.0; }
  bool asks_energy() const override { return true; }
  Memory memory() const override {
    const auto of = [](const Iterate& it) { return bytes_of(it.velocity, it.residual, it.terms); };
    return {bytes_of(bending_, start_x_, start_velocity_, load_, all_load_, correction_, x_, cloth_,
                     force_) +
                of(now_) + of(trial_),
            memory_.solver_bytes(), memory_.preconditioner_bytes()};
  }

  IntegrationReport advance(const Team& team, const RowLayout& layout, const StepInputs& inputs,
                            ClothState& state, Points& body_velocity) override {
    midpoint_ = scheme_ == Scheme::Midpoint && !inputs.damped && !inputs.in_contact();
    const SchemeCoefficients c =
        coefficients(midpoint_ ? Scheme::Midpoint : Scheme::BackwardEuler, inputs.step);
    const BodyRows bodies(inputs.step, c);
    body_mass_ = bodies.masses(inputs.body_mass);
    Step step{team, layout, inputs, c, model_.n_vertices};
    step.inputs.body_mass = &body_mass_;
    begin_step(step, state, body_velocity);
    const double scale = first_guess(step) + inputs.step * norm(step, load_, step.n);
    const IntegrationReport report = iterate_to_tolerance(step, scale);
    move(step, state);
    body_velocity += bodies.velocity_share *
                     (now_.velocity.bottomRows(layout.n_rows() - step.n) - body_velocity);
    return report;
  }

 private:
  // One step: the arguments of advance() and the coefficients of its scheme.
  struct Step {
    const Team& team;
    const RowLayout& layout;
    StepInputs inputs;
    SchemeCoefficients c;
    Index n;  // number of cloth vertices

    double h() const { return inputs.step; }
    // [begin, end): cloth rows of this rank
    Index begin() const { return std::min(layout.begin(), n); }
    Index end() const { return std::min(layout.end(), n); }
  };

  // A velocity v+ at the end of the step. `residual` contains -r(v+); see the top of this file.
  struct Iterate {
    Points velocity, residual;
    ExtraTerms terms;
    double norm = 0.0;  // norm of the residual
    double term_energy = 0.0;
    double potential = NAN;  // NAN until it is evaluated
  };

  void begin_step(const Step& step, ClothState& state, const Points& body_velocity) {
    const Index n = step.n, rows = step.layout.n_rows();
    start_x_ = state.x;
    start_velocity_.resize(rows, 3);
    start_velocity_.topRows(n) = state.v;
    start_velocity_.bottomRows(rows - n) = body_velocity;
    load_ = step.inputs.force->whole(n);
    bending_.add(step.team, {step.begin(), step.end(), step.h(), step.c.time}, elasticity_, state,
                 load_);
    all_load_ = load_;
    if (!step.layout.single()) {
      all_load_.conservativeResize(rows, 3);
      step.layout.gather(all_load_.data(), 3);
    }
  }

  // Starts from constant velocity or from zero displacement, whichever has the smaller residual.
  // Contacts and taut cloth can make the residual of constant velocity arbitrarily large. Returns
  // the norm of the chosen residual.
  double first_guess(const Step& step) {
    now_.velocity = start_velocity_;
    trial_.velocity =
        midpoint_ ? Points(-start_velocity_) : Points(Points::Zero(start_velocity_.rows(), 3));
    for (Iterate* guess : {&now_, &trial_}) {
      cloth_ = guess->velocity.topRows(step.n);
      prescribe_velocities(step.inputs, start_x_, cloth_);
      guess->velocity.topRows(step.n) = cloth_;
      evaluate(step, *guess);
    }
    if (trial_.norm < now_.norm) std::swap(now_, trial_);
    return now_.norm;
  }

  // Iterates until no update of the friction limits is due (see roughly_known) and the residual is
  // at most the tolerance times `scale` or is accepted as a rounding error (see
  // rounding_tolerance). `scale` is the norm of the first residual plus that of the impulse of the
  // loads on the cloth. Without loads, for example, `scale` itself may be a rounding error; no
  // residual then meets the tolerance. Friction limits use the normal forces at the start of the
  // time step until the residual has fallen as roughly_known describes, and then those of the
  // latest update. Throws NewtonFailure if the iteration does not converge.
  IntegrationReport iterate_to_tolerance(const Step& step, double scale) {
    const auto relative = [&] { return scale > 0.0 ? now_.norm / scale : 0.0; };
    IntegrationReport report;
    report.newton_iterations = 0;
    report.newton_residuals.push_back(relative());
    best_ = now_.norm;
    const double tolerance = options_.newton_tolerance * scale;
    const double rough = std::max(tolerance, roughly_known * now_.norm);
    bool new_limits = step.inputs.terms_at && !step.inputs.terms->empty(), rounded = false;
    int updates = 0;
    while ((!(now_.norm <= tolerance) && !rounded) || new_limits) {
      if (new_limits && (now_.norm <= (updates == 0 ? rough : tolerance) || rounded)) {
        evaluate(step, now_, TermRequest::NewLimits);
        best_ = now_.norm;
        rounded = false;
        new_limits = ++updates < most_updates && now_.norm > limit_tolerance * scale;
        continue;
      }
      if (report.newton_iterations == options_.max_newton_iterations)
        give_up("did not converge", step, report);
      if (!iterate(step, report)) {
        rounded = std::max(now_.norm, default_tolerance * scale) <=
                  rounding_tolerance * rounding_error(step);
        if (!rounded) give_up("found no step that lowers residual or potential", step, report);
        continue;
      }
      ++report.newton_iterations;
      report.newton_residuals.push_back(now_.norm / scale);
    }
    report.residual = relative();
    return report;
  }

  // Takes one Newton step. Returns false if search() accepts none. The exact Jacobian gives
  // quadratic convergence, but it may be indefinite near buckling. The positive semi-definite
  // Jacobian then still gives a descent direction. The exact Jacobian is tried in all Newton steps
  // if the options select it, and otherwise from the third Newton step on.
  bool iterate(const Step& step, IntegrationReport& report) {
    const bool try_exact =
        options_.jacobian == JacobianKind::Exact || report.newton_iterations >= 2;
    if (try_exact && solve(step, JacobianKind::Exact, report) && search(step, 0.1)) return true;
    if (!solve(step, JacobianKind::Positive, report) || !search(step, 1e-4)) return false;
    if (try_exact) go_further(step);
    return true;
  }

  // Line search. Tries the fractions 1, 1/2, 1/4 ... of the Newton step, down to `least`. Accepts
  // a fraction by its residual (see least_gain) or because it lowers the potential. The second
  // criterion is needed near buckling, where the residual must first grow on the way to the
  // solution. Neither criterion allows cycles. The combination is our choice. Returns false if no
  // fraction is accepted.
  bool search(const Step& step, double least) {
    for (length_ = 1.0; length_ >= least; length_ /= 2) {
      trial_.velocity = now_.velocity + length_ * correction_;
      evaluate(step, trial_);
      if (!(trial_.norm < least_gain * best_) && !(potential(step, trial_) < potential(step, now_)))
        continue;
      best_ = std::min(best_, trial_.norm);
      std::swap(now_, trial_);  // trial_ keeps the previous iterate
      return true;
    }
    return false;
  }

  // If the full Newton step was accepted, doubles it as long as the potential decreases. Near a
  // saddle of the potential, the positive Jacobian is far too stiff along the unstable mode, so
  // every Newton step would be too short.
  void go_further(const Step& step) {
    if (length_ < 1.0) return;
    const Points origin = trial_.velocity;
    for (;;) {
      trial_.velocity = origin + 2 * length_ * correction_;
      evaluate(step, trial_);
      if (!(potential(step, trial_) < potential(step, now_))) return;
      std::swap(now_, trial_);
      best_ = std::min(best_, now_.norm);
      length_ *= 2;
    }
  }

  // Throws NewtonFailure for the vertex that has the largest residual, in the metric of norm(),
  // among those that are not prescribed.
  [[noreturn]] void give_up(const char* how, const Step& step, const IntegrationReport& report) {
    step.layout.gather(now_.residual.data(), 3);
    Index worst = 0;
    double largest = -1.0;
    for (Index i = 0; i < step.n; ++i) {
      const double size =
          (*step.inputs.fixed)[i] ? 0.0 : now_.residual.row(i).squaredNorm() / model_.mass[i];
      if (size > largest) largest = size, worst = i;
    }
    throw NewtonFailure(
        formatted("the Newton loop of {} {} ({} iterations, relative residual {:.6g}, tolerance "
                  "{:.6g}); shorten integrator.step or raise integrator.newton_tolerance",
                  name_, how, report.newton_iterations, report.newton_residuals.back(),
                  options_.newton_tolerance),
        worst);
  }

  // Estimates the norm of the rounding error of the residual as the norm of its change when the
  // whole cloth is moved along all three axes at once, by a third of the largest absolute
  // coordinate. Without rounding, this motion changes no force. Overwrites trial_.
  double rounding_error(const Step& step) {
    const Points start = start_x_;
    const double largest = start.size() > 0 ? start.cwiseAbs().maxCoeff() : 0.0;
    start_x_.array() += largest / 3.0;
    trial_.velocity = now_.velocity;
    evaluate(step, trial_);
    start_x_ = start;
    return norm(step, trial_.residual - now_.residual, step.layout.n_rows());
  }

  // Norm of r in the metric M^-1 over the first n_rows rows, without rows of prescribed motion. It
  // is bitwise identical on any number of ranks.
  double norm(const Step& step, const Points& r, Index n_rows) {
    const RowLayout& layout = step.layout;
    std::vector<double> sums((layout.n_rows() + rows_per_block - 1) / rows_per_block, 0.0);
    const Index first = layout.begin() / rows_per_block;
    const Index last = (layout.end() + rows_per_block - 1) / rows_per_block;
    const auto square = [&](Index i) {
      if (i < step.n) return r.row(i).squaredNorm() / model_.mass[i];
      return r.row(i).dot((*step.inputs.body_mass)[i - step.n].llt().solve(r.row(i).transpose()));
    };
    parallel_for(
        step.team, last - first,
        [&](Index b) {
          const Index block = first + b;
          const Index end = std::min<Index>(n_rows, (block + 1) * rows_per_block);
          double sum = 0.0;
          for (Index i = block * rows_per_block; i < end; ++i)
            if (!(*step.inputs.fixed)[i]) sum += square(i);
          sums[block] = sum;
        },
        8);
    return std::sqrt(layout.sum(sums));
  }

  // Displacement at which forces are evaluated. `velocity` is that at the end of the step.
  Points displacement(double h, const Points& velocity) const {
    return midpoint_ ? Points(h / 4 * (start_velocity_ + velocity)) : Points(h * velocity);
  }

  // Evaluates the terms, the residual (owned rows) and its norm at the velocity of an iterate.
  void evaluate(const Step& step, Iterate& it, TermRequest request = TermRequest::Derivative) {
    const Points moved = displacement(step.h(), it.velocity);
    evaluate_cloth(step, moved, it);
    for (Index row = std::max(step.n, step.layout.begin()); row < step.layout.end(); ++row)
      it.residual.row(row) = -((*step.inputs.body_mass)[row - step.n] *
                               (it.velocity.row(row) - start_velocity_.row(row)).transpose())
                                  .transpose();
    if (step.inputs.terms) {
      it.terms = *step.inputs.terms;
      it.term_energy = step.inputs.terms_at
                           ? (*step.inputs.terms_at)(moved, step.c.time, request, it.terms)
                           : linear_terms_at(moved, step.c.time, it.terms);
      add_term_gradients(it.terms, step.layout, step.h(), it.residual);
    }
    it.norm = norm(step, it.residual, step.layout.n_rows());
    it.potential = NAN;
  }

  // In the owned rows of cloth, sets the residual without the extra terms. Sets all other rows of
  // the residual to zero.
  void evaluate_cloth(const Step& step, const Points& moved, Iterate& it) {
    const Index n = step.n, begin = step.begin(), end = step.end();
    x_ = start_x_ + moved.topRows(n);
    cloth_ = midpoint_ ? Points(0.5 * (start_velocity_ + it.velocity).topRows(n))
                       : Points(it.velocity.topRows(n));
    force_ = load_;
    elasticity_.add_implicit_forces(step.team, x_, &cloth_, begin, end, force_);
    it.residual = Points::Zero(step.layout.n_rows(), 3);
    parallel_for(step.team, end - begin, [&](Index i) {
      const Index row = begin + i;
      it.residual.row(row) = step.h() * force_.row(row) -
                             model_.mass[row] * (it.velocity.row(row) - start_velocity_.row(row));
    });
  }

  static double linear_terms_at(const Points& moved, double time, ExtraTerms& terms) {
    double energy = 0.0;
    for (ExtraTerm& term : terms) energy += term.move_linearly(moved, time);
    return energy;
  }

  // Potential 1/2 |v+ - v|_M^2 - h f_ext.v+ + c psi(x_e), with symbols as at the top of this file
  // and the energy psi of cloth and terms. With c = 1 (backward Euler) or 4 (midpoint), its
  // gradient with respect to v+ is r if there are no viscous forces. Collective.
  double potential(const Step& step, Iterate& it) {
    if (!std::isnan(it.potential)) return it.potential;
    const Index n = step.n;
    const double h = step.h(), c = midpoint_ ? 4.0 : 1.0;
    x_ = start_x_ + displacement(h, it.velocity).topRows(n);
    double sum = parallel_sum(step.team, n, [&](Index i) {
      const Vec3 change = (it.velocity.row(i) - start_velocity_.row(i)).transpose();
      return 0.5 * model_.mass[i] * change.squaredNorm() -
             h * all_load_.row(i).dot(it.velocity.row(i));
    });
    for (Index row = n; row < it.velocity.rows(); ++row) {
      const Vec3 change = (it.velocity.row(row) - start_velocity_.row(row)).transpose();
      sum += 0.5 * change.dot((*step.inputs.body_mass)[row - n] * change);
    }
    sum += c * elasticity_.membrane_energy(step.team, x_);
    if (elasticity_.implicit_bending()) sum += c * elasticity_.bending_energy(step.team, x_);
    if (step.inputs.terms) sum += c * it.term_energy;
    return it.potential = sum;
  }

  // Sets correction_ to the Newton correction of now_. Returns false, on all ranks, if the solver
  // throws StepFailure for the exact Jacobian, which may be indefinite.
  bool solve(const Step& step, JacobianKind kind, IntegrationReport& report) {
    const Points moved = displacement(step.h(), now_.velocity);
    x_ = start_x_ + moved.topRows(step.n);
    elasticity_.assemble(step.team, x_, {kind, {step.c.c_k, step.c.c_d}}, step.begin(), step.end());
    StepInputs at_iterate = step.inputs;
    if (step.inputs.terms) at_iterate.terms = &now_.terms;
    if (step.inputs.terms_at && kind == JacobianKind::Positive) {
      secant_ = *step.inputs.terms;
      (*step.inputs.terms_at)(moved, step.c.time, TermRequest::Secant, secant_);
      at_iterate.terms = &secant_;
    }
    correction_ = Points::Zero(step.layout.n_rows(), 3);
    try {
      const StepSystem system{at_iterate, elasticity_, step.c.c_k, now_.residual};
      const LinearReport solved =
          solver_.solve(step.team, step.layout, system, correction_, memory_, Unchanged::Nothing);
      report.linear_iterations += solved.iterations;
      return true;
    } catch (const StepFailure&) {
      if (kind == JacobianKind::Exact) return false;
      throw;
    }
  }

  // Sets velocities and positions at the end of the step.
  void move(const Step& step, ClothState& state) {
    const double weight = midpoint_ ? step.h() / 2 : step.h();
    parallel_for(step.team, step.n, [&](Index i) {
      const Vec3 v1 = now_.velocity.row(i);
      const Vec3 sum = midpoint_ ? Vec3(v1 + state.v.row(i).transpose()) : v1;
      state.x.row(i) += weight * sum.transpose();
      state.v.row(i) = v1;
    });
    place_fixed(step.inputs, state.x);
  }

  bool midpoint_;  // true: the current or last step is a midpoint step
  Scheme scheme_;
  ExplicitBending bending_;
  std::string_view name_;
  NewtonOptions options_;
  const ClothModel& model_;
  Elasticity& elasticity_;
  StepSolve solver_;
  SolveMemory memory_;  // reused storage

  // Scratch memory of a step.
  std::vector<Mat3> body_mass_;
  Points start_x_, start_velocity_, load_, all_load_, correction_;
  Iterate now_, trial_;
  ExtraTerms secant_;
  double best_ = 0.0;    // smallest residual since the last update of the friction limits
  double length_ = 1.0;  // factor of correction_ in the current Newton step
  Points x_, cloth_, force_;
};

}  // namespace

std::unique_ptr<Integrator> make_newton(Scheme scheme, std::string_view name,
                                        const NewtonOptions& options, const ClothModel& model,
                                        Elasticity& elasticity) {
  return std::make_unique<NewtonIntegrator>(scheme, name, options, model, elasticity);
}

}  // namespace loomstone
