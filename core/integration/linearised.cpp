// Linearised schemes: semi-implicit Euler ((2.51) of [Thomaszewski2010], with the term h D v that
// is omitted there), implicit midpoint and BDF-2; see docs/method.md, "Integrators". A step solves
// a linear system for the change of velocity dv, with the mass M, and the stiffness K and damping D
// at its start:
//   (M + c_d D + c_k K) dv = inertia + sigma (f_ext - f_el(x) - D w)
//                            - (sigma / c_k) (c_d D + c_k K) u0.
// Here c_d, c_k and sigma are SchemeCoefficients, f_ext are the loads and explicit bending forces,
// f_el is the gradient of the remaining elastic energy, and u0 is the displacement at which forces
// are evaluated if dv = 0. For BDF-2, x_ and v_ belong to the start of the last step, and
// inertia = b M (v - v_) and w = -b (x - x_) / sigma with b = SchemeCoefficients::history. For the
// other schemes, b is 0.
// Extra terms (extra_terms.h) add to the matrix and to the right-hand side.
#include <algorithm>
#include <cmath>

#include "core/base/message.h"
#include "core/base/own_rows.h"
#include "core/integration/explicit_bending.h"
#include "core/integration/integrator_factories.h"
#include "core/integration/scheme_coefficients.h"
#include "core/integration/step_solve.h"

namespace loomstone {

namespace {

// The contact forces of the first solve are kept if their relative error (ContactError::relative())
// is below `force_tolerance`. Those of a later solve are kept if their relative error is below
// `force_tolerance_again`. A step has at most `most_solves` solves. These numbers are our choice.
// In a landing, the normal forces of the first solve can be three times as large as those of the
// second one. With `most_solves` = 2, sheets that land on a floor have up to 3.4 times the friction
// of Coulomb's law. With `most_solves` = 5, a light stiff sheet that slides on a floor stops in a
// single step. With `force_tolerance` = 0.1, a sheet on an incline that is 6 % steeper than
// friction can hold starts to slide half a second late. With `force_tolerance_again` = 0.5, a disc
// that turns with a turntable creeps on it. With 0.1, the scene twist with 1,800 triangles takes
// five times as many iterations.
constexpr double force_tolerance = 0.02, force_tolerance_again = 1.0;
constexpr int most_solves = 12;
// With contacts, the tolerance of the first solve is at least this value, because this solve only
// predicts the motion of contacts. The result of the step meets the full tolerance; see
// solve_with_contacts(). Our choice: friction may have an error of a fiftieth, so a tolerance of a
// hundredth is accurate enough.
constexpr double rough_tolerance = 1e-2;
// At rest, the right-hand side is nearly zero, and solving to a fraction of it would cost as many
// iterations as in motion. The tolerance is therefore relative to at least this fraction of the
// momentum that gravity gives to freely falling cloth in the time SchemeCoefficients::sigma. With a
// tolerance of 1e-4, accelerations of cloth at rest are then wrong by about 1e-5 g.
constexpr double negligible_part = 0.1;

class LinearisedIntegrator final : public Integrator {
 public:
  LinearisedIntegrator(Scheme scheme, const ImplicitOptions& options, const ClothModel& model,
                       Elasticity& elasticity)
      : scheme_(scheme),
        taken_(scheme),
        kind_(options.jacobian),
        model_(model),
        elasticity_(elasticity),
        tolerance_(options.tolerance),
        direct_(options.linear_solver == LinearMethod::Direct ||
                options.linear_solver == LinearMethod::Supernodal),
        corrects_stress_(options.accuracy.has_value()),
        bending_(scheme != Scheme::BackwardEuler),
        solver_({options.linear_solver, options.tolerance, options.max_iterations}) {}

  bool implicit() const override { return true; }
  Memory memory() const override {
    return {
        bytes_of(rhs_, rhs_with_terms_, displacement_, drift_) +
            bytes_of(bending_, next_x_, next_v_, moved_, middle_, terms_, next_terms_, body_mass_),
        memory_.solver_bytes(), memory_.preconditioner_bytes()};
  }
  bool needs_all_terms() const override { return direct_; }
  bool damps() const override { return scheme_ == Scheme::BackwardEuler; }
  bool keeps_neglected_energy() const override { return !damps(); }
  double time_of_forces() const override { return taken_ == Scheme::Midpoint ? 0.5 : 1.0; }
  const ExtraTerms* terms_of_last_solve() const override {
    return solved_again_ ? &terms_ : nullptr;
  }

  IntegrationReport advance(const Team& team, const RowLayout& layout, const StepInputs& inputs,
                            ClothState& state, Points& body_velocity) override {
    // Length of this step divided by that of the last step, or 1 if the latter is unknown. BDF-2 is
    // unstable for ratios above 1 + sqrt(2) = 2.41. If the ratio is at least 2.4, if there is no
    // history, or if StepInputs::couples_bodies is true, midpoint takes the place of BDF-2. If
    // `damp` is true, backward Euler takes the step in any case.
    const double ratio = state.change_scale(inputs.step);
    const bool has_history =
        state.previous_x.rows() == model_.n_vertices && ratio < 2.4 && !inputs.couples_bodies;
    const bool damp = inputs.damped || inputs.in_contact();
    const Scheme undamped = scheme_ == Scheme::Bdf2 && !has_history ? Scheme::Midpoint : scheme_;
    const Scheme scheme = damp ? Scheme::BackwardEuler : undamped;
    taken_ = scheme;
    const SchemeCoefficients c = coefficients(scheme, inputs.step, ratio);
    const BodyRows bodies(inputs.step, c);
    body_mass_ = bodies.masses(inputs.body_mass);
    Step step{team, layout, inputs, scheme, c, model_.n_vertices, state.last_change};
    step.inputs.body_mass = &body_mass_;
    step.has_change = state.last_change.rows() == layout.n_rows();

    resize_tables(step);
    set_start(step, state, body_velocity);
    assemble(step, state);
    const Solution solution = solve_with_contacts(step);
    move(step, state);
    body_velocity += bodies.velocity_share * step.change.bottomRows(layout.n_rows() - step.n);
    return {1, solution.iterations, solution.residual, {}, 0};
  }

 private:
  // One step: the arguments of advance() and the coefficients of its scheme.
  struct Step {
    const Team& team;
    const RowLayout& layout;
    StepInputs inputs;
    Scheme scheme;
    SchemeCoefficients c;
    Index n;  // number of cloth vertices
    // (rows x 3) dv [m/s] or, in rows of bodies, y (see BodyRows). On entry, may contain the values
    // of the last step.
    Points& change;
    bool has_change = false;  // true: on entry, `change` contains the change of the last step

    bool has_terms() const { return inputs.terms && !inputs.terms->empty(); }
    // True if friction must be updated after a solve, because it depends on slip and normal force
    // at the end of the step. This is the same on all ranks.
    bool asks_forces() const { return inputs.in_contact(); }
    // [begin, end): cloth rows of this rank
    Index begin() const { return std::min(layout.begin(), n); }
    Index end() const { return std::min(layout.end(), n); }
  };
  struct Solution {
    int iterations;
    double residual;
  };

  // Replaces `table` by zeros (rows x 3) if it does not have this number of rows. Rows that no step
  // writes stay zero.
  static void keep_zero_outside(Points& table, Index rows) {
    if (table.rows() != rows) table = Points::Zero(rows, 3);
  }

  void resize_tables(const Step& step) {
    for (Points* const table : {&step.change, &displacement_})
      keep_zero_outside(*table, step.layout.n_rows());
    for (OwnRows* const table : {&rhs_, &rhs_with_terms_})
      table->resize(step.layout.begin(), step.layout.end());
  }

  // The forces f_ext - f_el(x) - D w on cloth (see the top of this file) [N], in rows of this rank.
  // They need no table of their own, because rhs_with_terms_ is set after their last use.
  OwnRows& force() { return rhs_with_terms_; }

  // Sets u0 of a row: the displacement at which forces are evaluated if dv is zero.
  void displace(const Step& step, const ClothState& state, const Points& body_velocity, Index row) {
    const bool cloth = row < step.n;
    const Vec3 velocity(cloth ? state.v.row(row) : body_velocity.row(row - step.n));
    Vec3 moved = step.c.reach * velocity;
    if (step.scheme == Scheme::Bdf2 && cloth)
      moved += step.c.history * (state.x.row(row) - state.previous_x.row(row)).transpose();
    if (step.scheme == Scheme::Bdf2 && !cloth) moved = step.inputs.step * velocity;
    displacement_.row(row) = moved;
  }

  // Sets u0, the loads and the initial guess of dv. For prescribed vertices, dv changes the
  // velocity to the mean velocity of the motion to the target.
  void set_start(const Step& step, const ClothState& state, const Points& body_velocity) {
    const RowLayout& layout = step.layout;
    // With contacts, the change of velocity in the last step is not used as a warm start. Our
    // choice: the residual of this guess is nearly always larger than that of a zero guess.
    const bool warm = !step.asks_forces() && step.has_change;
    const double scale = state.change_scale(step.inputs.step);
    parallel_for(step.team, layout.end() - layout.begin(), [&](Index i) {
      const Index row = layout.begin() + i;
      displace(step, state, body_velocity, row);
      Vec3 change = warm ? Vec3(scale * step.change.row(row)) : Vec3(Vec3::Zero());
      if (row < step.n && (*step.inputs.fixed)[row])
        change = (step.inputs.target->row(row) - state.x.row(row)).transpose() / step.inputs.step -
                 Vec3(state.v.row(row));
      step.change.row(row) = change;
      rhs_.row(row).setZero();
      if (row < step.n) force().row(row) = step.inputs.force->row(row);
    });
    displace_rows_of_others(step, state, body_velocity);
  }

  // Sets u0 (displacement_) in the rows of other ranks that this rank reads: the rows of terms and
  // the halo of the matrix. If there are many terms, sets it in all rows of other ranks.
  void displace_rows_of_others(const Step& step, const ClothState& state,
                               const Points& body_velocity) {
    const RowLayout& layout = step.layout;
    if (layout.single()) return;
    if (step.has_terms() && 4 * step.inputs.terms->size() > static_cast<std::size_t>(step.n)) {
      parallel_for(step.team, layout.n_rows(), [&](Index row) {
        if (!layout.owns(row)) displace(step, state, body_velocity, row);
      });
      return;
    }
    if (step.has_terms())
      for (const ExtraTerm& term : *step.inputs.terms)
        for (int e = 0; e < term.n_entries; ++e)
          if (const Index row = term.entries[e].row; !layout.owns(row))
            displace(step, state, body_velocity, row);
    for (const Halo::Neighbour& neighbour : solver_.halo(elasticity_.matrix(), layout).neighbours)
      for (const Index row : neighbour.receive) displace(step, state, body_velocity, row);
  }

  // Assembles the matrix M + c_d D + c_k K, and the right-hand side without terms.
  void assemble(const Step& step, ClothState& state) {
    const SchemeCoefficients& c = step.c;
    const Index begin = step.begin(), end = step.end();
    bending_.add(step.team, {begin, end, step.inputs.step, c.time}, elasticity_, state, force());
    const Points* viscous_velocity = nullptr;
    if (step.scheme == Scheme::Bdf2) {
      drift_ = -c.history / c.sigma * (state.x - state.previous_x);
      viscous_velocity = &drift_;
    }
    elasticity_.add_implicit_forces(step.team, state.x, viscous_velocity, begin, end, force());
    const JacobianTerms terms{kind_, {c.c_k, c.c_d}, past_motion(state, step.scheme)};
    elasticity_.assemble(step.team, state.x, terms, begin, end, {&displacement_, &rhs_});
    parallel_for(step.team, end - begin, [&](Index i) {
      const Index row = begin + i;
      rhs_.row(row) = c.sigma * force().row(row) - c.sigma / c.c_k * rhs_.row(row);
      if (step.scheme == Scheme::Bdf2)
        rhs_.row(row) +=
            c.history * model_.mass[row] * (state.v.row(row) - state.previous_v.row(row));
    });
  }

  // Returns the motion whose neglected strain (1/2 dF^T dF) the geometric stiffness omits, or an
  // empty PastMotion if nothing is omitted. Without this strain, the stress in the geometric
  // stiffness is that of the linear model of the last step: at the middle of the last step for
  // midpoint, and at its end otherwise. Stress from the neglected strain would resist rotation.
  PastMotion past_motion(const ClothState& state, Scheme scheme) {
    if (!corrects_stress_) return {};
    if (scheme_ == Scheme::BackwardEuler) {
      if (!(state.previous_step > 0.0)) return {};
      return {state.v.data(), state.previous_step};
    }
    // Midpoint and BDF-2 take steps by backward Euler in order to damp. The stress from the
    // neglected strain damps, too, so it is kept.
    const bool damped = scheme == Scheme::BackwardEuler;
    if (damped || state.previous_x.rows() != model_.n_vertices) return {};
    moved_ = state.x - state.previous_x;
    if (scheme != Scheme::Midpoint) return {moved_.data(), 1.0};
    middle_ = 0.5 * (state.x + state.previous_x);
    return {moved_.data(), 0.5, middle_.data()};
  }

  // Solves for dv. With contacts, a first solve to a loose tolerance predicts their motion, which
  // gives the contact forces of the second solve. If the forces of the first solve were accurate
  // enough, the first solution is only refined to the full tolerance. If friction in a later solve
  // was far too large or too small for the normal forces, or if contacts pulled far more than
  // others pushed, another solve corrects this (see force_tolerance_again).
  Solution solve_with_contacts(const Step& step) {
    const bool asks = step.asks_forces();
    const double tolerance = step.inputs.tolerance_factor * tolerance_;
    const double rough = asks ? std::max(rough_tolerance, tolerance) : tolerance;
    add_terms(step, step.inputs);
    LinearReport solved = solve(step, step.inputs, rough, Unchanged::Nothing);
    int iterations = solved.iterations;
    solved_again_ = false;
    StepInputs again = step.inputs;
    for (int solves = 1; asks && solved.converged && solves < most_solves; ++solves) {
      next_terms_ = *again.terms;
      const bool wrong =
          (*step.inputs.forces_after)(displacement_ + step.c.c_k / step.c.sigma * step.change,
                                      step.c.time, solved_again_, next_terms_) >=
          (solved_again_ ? force_tolerance_again : force_tolerance);
      if (wrong) {
        solved_again_ = true;
        terms_.swap(next_terms_);
        again.terms = &terms_;
        add_terms(step, again);
      }
      if (wrong || solved.residual > tolerance) {
        solved = solve(step, again, tolerance, wrong ? Unchanged::Matrix : Unchanged::System);
        iterations += solved.iterations;
      }
      if (!wrong) break;
    }
    if (!solved.converged)
      throw StepFailure(formatted(
          "the linear solve of the implicit step did not reach its tolerance in {} iterations "
          "(residual {:.3g}); shorten integrator.step, raise integrator.tolerance or use "
          "linear_solver=\"direct\"",
          solved.iterations, solved.residual));
    return {iterations, solved.residual};
  }

  // Sets the full right-hand side, including the terms of `inputs`.
  void add_terms(const Step& step, const StepInputs& inputs) {
    const Index begin = step.layout.begin();
    parallel_for(step.team, step.layout.end() - begin,
                 [&](Index i) { rhs_with_terms_.row(begin + i) = rhs_.row(begin + i); });
    if (inputs.terms)
      add_term_forces(*inputs.terms, step.layout, step.c, displacement_, rhs_with_terms_);
  }

  LinearReport solve(const Step& step, const StepInputs& inputs, double tolerance,
                     Unchanged unchanged) {
    const StepSystem system{inputs,
                            elasticity_,
                            step.c.c_k,
                            rhs_with_terms_,
                            tolerance,
                            &model_.mass,
                            negligible_part * step.c.sigma * inputs.gravity};
    return solver_.solve(step.team, step.layout, system, step.change, memory_, unchanged);
  }

  // Sets velocities and positions at the end of the step.
  void move(const Step& step, ClothState& state) {
    const double h = step.inputs.step;
    if (scheme_ != Scheme::BackwardEuler) next_x_ = state.x;
    if (scheme_ == Scheme::Bdf2) next_v_ = state.v;
    parallel_for(step.team, step.n, [&](Index i) {
      const Vec3 v0 = state.v.row(i), v1 = v0 + step.change.row(i).transpose();
      Vec3 x1 = state.x.row(i);
      if (step.scheme == Scheme::BackwardEuler)
        x1 += h * v1;
      else if (step.scheme == Scheme::Midpoint)
        x1 += h / 2 * (v0 + v1);
      else
        x1 += step.c.history * (x1 - state.previous_x.row(i).transpose()) + step.c.sigma * v1;
      state.x.row(i) = x1;
      state.v.row(i) = v1;
    });
    place_fixed(step.inputs, state.x);
    if (scheme_ == Scheme::BackwardEuler) return;
    // Contact forces are not smooth in time, so a step with contacts leaves no history for BDF-2.
    if (scheme_ == Scheme::Bdf2 && step.inputs.in_contact())
      next_x_.resize(0, 3), next_v_.resize(0, 3);
    state.previous_x.swap(next_x_), state.previous_v.swap(next_v_);
  }

  Scheme scheme_;
  Scheme taken_;  // scheme of the current or last step
  JacobianKind kind_;
  const ClothModel& model_;
  Elasticity& elasticity_;
  double tolerance_;
  bool direct_;
  // True if ImplicitOptions::accuracy bounds the error of steps. The geometric stiffness then omits
  // the strain that the last step neglected (see past_motion()). Otherwise, this strain is kept,
  // because it also damps snapping wrinkles.
  bool corrects_stress_;
  ExplicitBending bending_;
  StepSolve solver_;
  SolveMemory memory_;  // reused storage; no results carry over between steps
  // Scratch memory of a step.
  std::vector<Mat3> body_mass_;
  ExtraTerms terms_;           // terms of the last solve, if the step was solved again
  ExtraTerms next_terms_;      // terms for another solve
  bool solved_again_ = false;  // true: the current or last step was solved again with terms_
  OwnRows rhs_, rhs_with_terms_;
  Points displacement_, drift_, next_x_, next_v_;
  Points moved_, middle_;  // see past_motion()
};

}  // namespace

std::unique_ptr<Integrator> make_linearised(Scheme scheme, const ImplicitOptions& options,
                                            const ClothModel& model, Elasticity& elasticity) {
  return std::make_unique<LinearisedIntegrator>(scheme, options, model, elasticity);
}

}  // namespace loomstone
