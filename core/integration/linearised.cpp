// Schemes that solve one linear system a step, with the stiffness K and damping D of its start:
//   (M + c_d D + c_k K) dv = inertia + sigma (f_ext - f_el) - [M + c_d D + c_k K - M] terms,
// semi-implicit backward Euler (2.51, with the term h D v that the thesis drops), implicit midpoint
// and BDF-2, both linearised. method.md 1.4. With u0 the displacement that would follow from dv =
// 0, the right side of all three is
//   inertia + sigma (f_ext - f_el(x) - D w) - (sigma / c_k) (c_d D + c_k K) u0,
// where w = -(x - x_) / (3 sigma) for BDF-2 and 0 for the others.
#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/integration/schemes.h"
#include "core/integration/step_solve.h"

namespace loomstone {

namespace {

// The share of friction in error that is accepted without a second solve. Our choice: sheets that
// slide need one as they start and where contacts change, none in steady sliding and at rest; the
// claims on friction hold with one.
constexpr double friction_tolerance = 0.1;
// To what the solve is done that tells how contacts move. Our choice: friction is judged to a
// tenth, so a hundredth is enough; a drape of 14,450 triangles takes 0.62 of the iterations of two
// solves to 1e-4, with a tenth 0.58.
constexpr double rough_tolerance = 1e-2;

enum class Scheme { SemiImplicitEuler, Midpoint, Bdf2 };

class LinearisedIntegrator final : public Integrator {
 public:
  LinearisedIntegrator(Scheme scheme, const IntegratorOptions& options, const ClothModel& model,
                       Elasticity& elasticity)
      : scheme_(scheme),
        kind_(options.jacobian == "exact" ? JacobianKind::Exact : JacobianKind::Positive),
        model_(model),
        elasticity_(elasticity),
        tolerance_(options.tolerance),
        solver_({options.linear_solver, options.tolerance, options.max_iterations}) {}

  bool implicit() const override { return true; }

  IntegrationReport advance(const Team& team, const RowLayout& layout, const StepInputs& given,
                            ClothState& state, Points& body_velocity) override {
    StepInputs inputs = given;
    const Index n = model_.n_vertices, rows = layout.n_rows();
    const Index begin = std::min(layout.begin(), n), end = std::min(layout.end(), n);
    const double h = inputs.step;
    const bool has_history = state.previous_x.rows() == n;
    const Scheme scheme = scheme_ == Scheme::Bdf2 && !has_history ? Scheme::Midpoint : scheme_;
    const double c_d = scheme == Scheme::SemiImplicitEuler ? h
                       : scheme == Scheme::Midpoint        ? h / 2
                                                           : 2 * h / 3;
    const double c_k = scheme == Scheme::SemiImplicitEuler ? h * h
                       : scheme == Scheme::Midpoint        ? h * h / 4
                                                           : 4 * h * h / 9;
    const double sigma = scheme == Scheme::Bdf2 ? 2 * h / 3 : h;
    const BodyRows body_rows(h, sigma, c_k, scheme == Scheme::Midpoint ? h / 2 : h);
    body_mass_ = body_rows.masses(given.body_mass);
    inputs.body_mass = &body_mass_;

    for (Points* const table : {&change_, &displacement_, &rhs_}) keep_zero_outside(*table, rows);
    for (Points* const table : {&cloth_displacement_, &force_, &product_})
      keep_zero_outside(*table, n);
    // Friction depends on slip and normal force at the end of the step, which a solve tells: a
    // rough one is enough. Where cloth is in contact the last change is no start for it: its
    // residual is nearly always larger than that of zero.
    const bool asks = inputs.friction_at && inputs.terms && !inputs.terms->empty();
    const bool starts_from_last = !asks && state.last_change.rows() == rows;
    const double reach = scheme == Scheme::SemiImplicitEuler ? h
                         : scheme == Scheme::Midpoint        ? h / 2
                                                             : 2 * h / 3;
    const auto velocity = [&](Index row) {
      return Vec3(row < n ? state.v.row(row) : body_velocity.row(row - n));
    };
    const auto displace = [&](Index row) {
      Vec3 moved = reach * velocity(row);
      if (scheme == Scheme::Bdf2 && row < n)
        moved += (state.x.row(row) - state.previous_x.row(row)).transpose() / 3.0;
      if (scheme == Scheme::Bdf2 && row >= n) moved = h * velocity(row);
      displacement_.row(row) = moved;
      if (row < n) cloth_displacement_.row(row) = moved;
    };
    parallel_for(team, layout.end() - layout.begin(), [&](Index i) {
      const Index row = layout.begin() + i;
      displace(row);
      Vec3 change = starts_from_last ? Vec3(state.last_change.row(row)) : Vec3(Vec3::Zero());
      // Prescribed motion enters as the change of velocity of fixed rows.
      if (row < n && (*inputs.fixed)[row])
        change = (inputs.target->row(row) - state.x.row(row)).transpose() / h - velocity(row);
      change_.row(row) = change;
      rhs_.row(row).setZero();
      if (row < n) force_.row(row) = inputs.force->row(row);
    });
    // Rows of other ranks that are read: terms may reach any.
    const bool any_row = inputs.terms && !inputs.terms->empty();
    if (any_row && !layout.single())
      parallel_for(team, rows, [&](Index row) {
        if (!layout.owns(row)) displace(row);
      });
    if (!any_row)
      for (const Halo::Neighbour& neighbour : solver_.halo(elasticity_.matrix(), layout).neighbours)
        for (const Index row : neighbour.receive) displace(row);

    // Loads and elastic force.
    add_bending(team, scheme, state, begin, end);
    if (scheme == Scheme::Bdf2) {
      drift_ = -(state.x - state.previous_x) / (3.0 * sigma);
      elasticity_.add_implicit_forces(team, state.x, &drift_, begin, end, force_);
    } else {
      elasticity_.add_implicit_forces(team, state.x, nullptr, begin, end, force_);
    }
    elasticity_.assemble(team, state.x, {kind_, {c_k, c_d}}, begin, end,
                         {&cloth_displacement_, &product_});
    parallel_for(team, end - begin, [&](Index i) {
      const Index row = begin + i;
      rhs_.row(row) = sigma * force_.row(row) - sigma / c_k * product_.row(row);
      if (scheme == Scheme::Bdf2)
        rhs_.row(row) += model_.mass[row] / 3.0 * (state.v.row(row) - state.previous_v.row(row));
    });
    const double term_time =
        scheme == Scheme::Midpoint ? h / 2 : h;  // when the scheme evaluates forces
    const double rough = asks ? std::max(rough_tolerance, tolerance_) : 0.0;
    LinearReport solved =
        solve(team, layout, inputs, sigma, c_k, term_time, rough, Unchanged::Nothing);
    int iterations = solved.iterations;
    if (asks && solved.converged) {
      StepInputs again = inputs;
      terms_ = *inputs.terms;
      const bool wrong = (*inputs.friction_at)(displacement_ + c_k / sigma * change_, term_time,
                                               terms_) >= friction_tolerance;
      if (wrong) again.terms = &terms_;
      if (wrong || solved.residual > tolerance_) {
        solved = solve(team, layout, again, sigma, c_k, term_time, 0.0,
                       wrong ? Unchanged::Matrix : Unchanged::System);
        iterations += solved.iterations;
      }
    }
    if (!solved.converged)
      throw StepFailure("the linear solve of the implicit step did not reach its tolerance in " +
                        std::to_string(solved.iterations) + " iterations (residual " +
                        std::to_string(solved.residual) +
                        "); shorten integrator.step, loosen integrator.tolerance or use "
                        "linear_solver=\"direct\"");

    move(team, scheme, h, inputs, state);
    state.last_change = change_;
    body_velocity += body_rows.velocity_share * change_.bottomRows(rows - n);
    return {1, iterations, solved.residual, {}};
  }

 private:
  LinearReport solve(const Team& team, const RowLayout& layout, const StepInputs& inputs,
                     double sigma, double c_k, double term_time, double tolerance,
                     Unchanged unchanged) {
    if (unchanged != Unchanged::System) {
      keep_zero_outside(sum_, rhs_.rows());
      parallel_for(team, layout.end() - layout.begin(),
                   [&](Index i) { sum_.row(layout.begin() + i) = rhs_.row(layout.begin() + i); });
      if (inputs.terms)
        add_term_forces(*inputs.terms, layout, sigma, term_time, displacement_, sum_);
    }
    return solver_.solve(team, layout, inputs, elasticity_, c_k, sum_, change_, tolerance,
                         unchanged);
  }

  // Rows of this rank are written at every step, those of others never.
  static void keep_zero_outside(Points& table, Index rows) {
    if (table.rows() != rows) table = Points::Zero(rows, 3);
  }

  // Explicit bending, extrapolated to the time at which a scheme of second order needs it.
  void add_bending(const Team& team, Scheme scheme, ClothState& state, Index begin, Index end) {
    if (elasticity_.implicit_bending()) return;
    keep_zero_outside(bending_, model_.n_vertices);
    parallel_for(team, end - begin, [&](Index i) { bending_.row(begin + i).setZero(); });
    elasticity_.add_explicit_bending(team, state.x, state.v, begin, end, bending_);
    const bool extrapolate =
        scheme_ != Scheme::SemiImplicitEuler && state.previous_bending.rows() == model_.n_vertices;
    if (!extrapolate)
      parallel_for(team, end - begin,
                   [&](Index i) { force_.row(begin + i) += bending_.row(begin + i); });
    else if (scheme == Scheme::Bdf2)
      force_ += 2.0 * bending_ - state.previous_bending;
    else
      force_ += 1.5 * bending_ - 0.5 * state.previous_bending;
    if (scheme_ != Scheme::SemiImplicitEuler) state.previous_bending = bending_;
  }

  void move(const Team& team, Scheme scheme, double h, const StepInputs& inputs,
            ClothState& state) {
    const Index n = model_.n_vertices;
    if (scheme_ == Scheme::Bdf2) next_x_ = state.x, next_v_ = state.v;
    parallel_for(team, n, [&](Index i) {
      const Vec3 v0 = state.v.row(i), v1 = v0 + change_.row(i).transpose();
      Vec3 x1 = state.x.row(i);
      if (scheme == Scheme::SemiImplicitEuler)
        x1 += h * v1;
      else if (scheme == Scheme::Midpoint)
        x1 += h / 2 * (v0 + v1);
      else
        x1 = (4.0 * x1 - state.previous_x.row(i).transpose()) / 3.0 + 2 * h / 3 * v1;
      state.x.row(i) = x1;
      state.v.row(i) = v1;
    });
    place_fixed(inputs, state.x);
    if (scheme_ == Scheme::Bdf2) state.previous_x = next_x_, state.previous_v = next_v_;
  }

  Scheme scheme_;
  JacobianKind kind_;
  const ClothModel& model_;
  Elasticity& elasticity_;
  double tolerance_;
  StepSolve solver_;
  std::vector<Mat3> body_mass_;
  ExtraTerms terms_;  // with friction that belongs to the solve before
  Points sum_, change_, displacement_, cloth_displacement_, rhs_, force_, drift_, product_,
      bending_, next_x_, next_v_;
};

}  // namespace

std::unique_ptr<Integrator> make_linearised(const IntegratorOptions& options,
                                            const ClothModel& model, Elasticity& elasticity) {
  const Scheme scheme = options.method == "semi-implicit-euler" ? Scheme::SemiImplicitEuler
                        : options.method == "implicit-midpoint" ? Scheme::Midpoint
                                                                : Scheme::Bdf2;
  return std::make_unique<LinearisedIntegrator>(scheme, options, model, elasticity);
}

}  // namespace loomstone
