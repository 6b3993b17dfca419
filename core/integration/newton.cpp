// Fully nonlinear backward Euler and implicit midpoint (2.54, 2.55) by Newton's method with a line search on the residual
//   r(v+) = M (v+ - v) - h (f_ext + f(x_e, v_e)),
// backward Euler: x_e = x + h v+, v_e = v+; midpoint: x_e = x + h/4 (v + v+), v_e = (v + v+)/2. Contact pairs and anchors
// are those of the start of the step, their forces linear in the displacement.
#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "core/base/error.h"
#include "core/integration/schemes.h"
#include "core/integration/step_solve.h"

namespace loomstone {

namespace {

class NewtonIntegrator final : public Integrator {
 public:
  NewtonIntegrator(bool midpoint, const IntegratorOptions& options, const ClothModel& model, Elasticity& elasticity)
      : midpoint_(midpoint),
        options_(options),
        kind_(options.jacobian == "exact" ? JacobianKind::Exact : JacobianKind::Positive),
        model_(model),
        elasticity_(elasticity),
        // Newton corrects what the inner solve leaves; its tolerance only sets the rate.
        solver_({options.linear_solver, std::min(options.tolerance, 1e-4), options.max_iterations}) {}

  bool implicit() const override { return true; }

  IntegrationReport advance(const Team& team, const RowLayout& layout, const StepInputs& inputs, ClothState& state,
                            Points& body_velocity) override {
    const Index n = model_.n_vertices, rows = layout.n_rows();
    const double h = inputs.step;
    start_velocity_.resize(rows, 3);
    start_velocity_.topRows(n) = state.v;
    start_velocity_.bottomRows(rows - n) = body_velocity;
    start_x_ = state.x;
    velocity_ = start_velocity_;
    Points cloth_velocity = velocity_.topRows(n);
    prescribe_velocities(inputs, state.x, cloth_velocity);
    velocity_.topRows(n) = cloth_velocity;

    load_ = *inputs.force;
    elasticity_.add_explicit_bending(team, state.x, state.v, std::min(layout.begin(), n), std::min(layout.end(), n), load_);

    all_load_ = load_;
    if (!layout.single()) {
      all_load_.conservativeResize(rows, 3);
      layout.gather(all_load_.data(), 3);
    }

    IntegrationReport report;
    report.newton_iterations = 0;
    const double load = h * norm(team, layout, inputs, load_, n);
    double residual = evaluate(team, layout, inputs, state, velocity_, residual_);
    const double scale = residual + load;
    std::array<double, 4> recent;
    recent.fill(residual);
    while (residual > options_.newton_tolerance * scale) {
      if (report.newton_iterations == options_.max_newton_iterations) fail("did not converge", report, residual / scale);
      // The positive Jacobian leads downhill from afar; near the solution the exact one converges quadratically, where the
      // cloth is not about to buckle (then it is indefinite and the positive one goes on).
      if (kind_ == JacobianKind::Exact || report.newton_iterations < 3 || !solve_exact(team, layout, inputs, report))
        solve(team, layout, inputs, kind_, report);
      // Accept what does not exceed the largest of the last four residuals, or what lowers the potential whose gradient the
      // residual is: the positive Jacobian is not the derivative, but its direction leads downhill. Our choice.
      const double bound = *std::max_element(recent.begin(), recent.end());
      double length = 1.0, next = 0.0, start_potential = NAN;
      for (;; length /= 2) {
        trial_ = velocity_ + length * correction_;
        next = evaluate(team, layout, inputs, state, trial_, trial_residual_);
        if (next <= (1.0 - 1e-4 * length) * bound) break;
        if (std::isnan(start_potential)) start_potential = potential(team, inputs, velocity_);
        if (potential(team, inputs, trial_) < start_potential) break;
        if (length < 1e-4) fail("found no step that lowers residual or potential", report, residual / scale);
      }
      velocity_.swap(trial_);
      residual_.swap(trial_residual_);
      residual = next;
      recent[report.newton_iterations++ % recent.size()] = residual;
    }
    report.residual = scale > 0.0 ? residual / scale : 0.0;
    const double weight = midpoint_ ? h / 2 : h;
    parallel_for(team, n, [&](Index i) {
      const Vec3 v1 = velocity_.row(i);
      const Vec3 sum = midpoint_ ? Vec3(v1 + state.v.row(i).transpose()) : v1;
      state.x.row(i) += weight * sum.transpose();
      state.v.row(i) = v1;
    });
    place_fixed(inputs, state.x);
    body_velocity = velocity_.bottomRows(rows - n);
    return report;
  }

 private:
  [[noreturn]] void fail(const char* what, const IntegrationReport& report, double relative) const {
    std::ostringstream out;
    out << "the Newton loop of " << options_.method << ' ' << what << " (" << report.newton_iterations
        << " iterations, relative residual " << relative << ", asked " << options_.newton_tolerance
        << "); shorten integrator.step or raise integrator.newton_tolerance";
    throw SolverFailure(out.str());
  }

  // Norm in the metric M^-1 over free rows, the same bits on any number of ranks.
  double norm(const Team& team, const RowLayout& layout, const StepInputs& inputs, const Points& r, Index n_rows) {
    const Index n = model_.n_vertices;
    std::vector<double> sums((layout.n_rows() + rows_per_block - 1) / rows_per_block, 0.0);
    const Index first = layout.begin() / rows_per_block;
    const Index last = (layout.end() + rows_per_block - 1) / rows_per_block;
    parallel_for(team, last - first, [&](Index b) {
      const Index block = first + b;
      double sum = 0.0;
      for (Index i = block * rows_per_block; i < std::min<Index>(n_rows, (block + 1) * rows_per_block); ++i) {
        if ((*inputs.fixed)[i]) continue;
        sum += i < n ? r.row(i).squaredNorm() / model_.mass[i]
                     : r.row(i).dot((*inputs.body_mass)[i - n].llt().solve(r.row(i).transpose()));
      }
      sums[block] = sum;
    }, 8);
    return std::sqrt(layout.ordered_sum(sums));
  }

  // r on owned rows; returns its norm.
  double evaluate(const Team& team, const RowLayout& layout, const StepInputs& inputs, const ClothState& state,
                  const Points& velocity, Points& r) {
    const Index n = model_.n_vertices, rows = layout.n_rows();
    const Index begin = std::min(layout.begin(), n), end = std::min(layout.end(), n);
    const double h = inputs.step;
    displacement_ = midpoint_ ? Points(h / 4 * (start_velocity_ + velocity)) : Points(h * velocity);
    x_ = state.x + displacement_.topRows(n);
    v_ = midpoint_ ? Points(0.5 * (start_velocity_ + velocity).topRows(n)) : Points(velocity.topRows(n));
    force_ = load_;
    elasticity_.add_implicit_forces(team, x_, &v_, begin, end, force_);
    r = Points::Zero(rows, 3);
    parallel_for(team, end - begin, [&](Index i) {
      const Index row = begin + i;
      r.row(row) = h * force_.row(row) - model_.mass[row] * (velocity.row(row) - start_velocity_.row(row));
    });
    for (Index row = std::max(n, layout.begin()); row < layout.end(); ++row)
      r.row(row) = -((*inputs.body_mass)[row - n] * (velocity.row(row) - start_velocity_.row(row)).transpose()).transpose();
    if (inputs.terms) add_term_forces(*inputs.terms, layout, h, midpoint_ ? h / 2 : h, displacement_, r);
    return norm(team, layout, inputs, r, rows);
  }

  // 1/2 |v+ - v|_M^2 - h f_ext.v+ + c psi(x_e), c = 1 for backward Euler, 4 for midpoint: minus r is its gradient where
  // nothing is viscous. Over all rows on every rank; needed only when the residual does not fall.
  double potential(const Team& team, const StepInputs& inputs, const Points& velocity) {
    const Index n = model_.n_vertices;
    const double h = inputs.step, c = midpoint_ ? 4.0 : 1.0;
    displacement_ = midpoint_ ? Points(h / 4 * (start_velocity_ + velocity)) : Points(h * velocity);
    x_ = start_x_ + displacement_.topRows(n);
    double sum = parallel_sum(team, n, [&](Index i) {
      const Vec3 change = (velocity.row(i) - start_velocity_.row(i)).transpose();
      return 0.5 * model_.mass[i] * change.squaredNorm() - h * all_load_.row(i).dot(velocity.row(i));
    });
    for (Index row = n; row < velocity.rows(); ++row) {
      const Vec3 change = (velocity.row(row) - start_velocity_.row(row)).transpose();
      sum += 0.5 * change.dot((*inputs.body_mass)[row - n] * change);
    }
    sum += c * elasticity_.membrane_energy(team, x_);
    if (elasticity_.implicit_bending()) sum += c * elasticity_.bending_energy(team, x_);
    if (!inputs.terms) return sum;
    for (const ExtraTerm& term : *inputs.terms) {
      Vec3 d = -(midpoint_ ? h / 2 : h) * term.drift;
      for (int e = 0; e < term.n_entries; ++e) d += term.entries[e].apply(displacement_.row(term.entries[e].row).transpose());
      sum += c * (term.gradient.dot(d) + 0.5 * d.dot(term.hessian * d));
    }
    return sum;
  }

  bool solve_exact(const Team& team, const RowLayout& layout, const StepInputs& inputs, IntegrationReport& report) {
    try {
      solve(team, layout, inputs, JacobianKind::Exact, report);
      return true;
    } catch (const SolverFailure&) {  // the same on all ranks
      return false;
    }
  }

  void solve(const Team& team, const RowLayout& layout, const StepInputs& inputs, JacobianKind kind,
             IntegrationReport& report) {
    const Index n = model_.n_vertices, begin = std::min(layout.begin(), n), end = std::min(layout.end(), n);
    const double h = inputs.step, c_k = midpoint_ ? h * h / 4 : h * h, c_d = midpoint_ ? h / 2 : h;
    // Positions that belong to the accepted velocity: a refused trial may have been evaluated last.
    x_ = midpoint_ ? Points(start_x_ + h / 4 * (start_velocity_ + velocity_).topRows(n))
                   : Points(start_x_ + h * velocity_.topRows(n));
    elasticity_.assemble(team, x_, kind, c_d, c_k, begin, end);
    correction_ = Points::Zero(layout.n_rows(), 3);
    const LinearReport solved = solver_.solve(team, layout, inputs, elasticity_, c_k, residual_, correction_);
    report.linear_iterations += solved.iterations;
  }

  bool midpoint_;
  IntegratorOptions options_;
  JacobianKind kind_;
  const ClothModel& model_;
  Elasticity& elasticity_;
  StepSolve solver_;
  Points start_x_, start_velocity_, velocity_, load_, all_load_, residual_, trial_, trial_residual_, correction_;
  Points displacement_, x_, v_, force_;
};

}  // namespace

std::unique_ptr<Integrator> make_newton(const IntegratorOptions& options, const ClothModel& model,
                                        Elasticity& elasticity) {
  return std::make_unique<NewtonIntegrator>(options.method == "nonlinear-midpoint", options, model, elasticity);
}

}  // namespace loomstone
