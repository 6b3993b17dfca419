#include "core/sim/step/stepper.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>

#include "core/base/error.h"
#include "core/cloth/air.h"
#include "core/sim/model/motion.h"
#include "core/sim/step/stage_timer.h"

namespace loomstone {

namespace {

// Ends the second phase of strain limits whatever becomes of the solve.
struct EndOfLimitPhase {
  Elasticity& elasticity;
  ~EndOfLimitPhase() { elasticity.leave_limit_phase(); }
};

// An attempt is taken back: its times and iterations were spent all the same.
void take_back(const StepReport& before, StepReport& report) {
  const StepReport spent = report;
  report = before;
  report.seconds = spent.seconds;
  report.newton_iterations = spent.newton_iterations,
  report.linear_iterations = spent.linear_iterations;
  report.limit_sweeps = spent.limit_sweeps, report.limit_evaluations = spent.limit_evaluations;
  report.rate_sweeps = spent.rate_sweeps;
  report.limit_rounds = spent.limit_rounds, report.limit_retreats = spent.limit_retreats;
}

// Nothing of a step of another length goes on: not the history, not the change of velocity that
// solves start from.
void forget_steps(ClothState& cloth) {
  cloth.forget_history();
  cloth.last_change.resize(0, 3);
}

}  // namespace

Stepper::Stepper(const Model& model, const IntegratorOptions& options, const Team& team,
                 const RowLayout& layout, const State& state)
    : model_(model),
      options_(options),
      team_(team),
      busy_(team.threads, 0.0),
      collision_team_(team),
      layout_(layout) {
  collision_team_.busy = busy_.data();
  const Index n = model.cloth.n_vertices;
  elasticity_ = std::make_unique<Elasticity>(model.cloth, bending_treatment(options, model.cloth));
  integrator_ = make_integrator(options, model.cloth, *elasticity_);
  contacts_in_solve_ = integrator_->implicit() && model.scene.response == "implicit";
  if (model.scene.collisions && n > 0)
    collision_ = std::make_unique<CollisionStage>(model.collision);
  if (model.n_bodies() > 0) {
    if (!model.magnets.empty() || !model.coils.empty() || !model.scene.bearings.empty())
      magnetics_ = std::make_unique<MagneticMotion>(model);
    // With magnets gravity and free rotation are theirs, between contacts.
    const Vec3 gravity = magnetics_ ? Vec3(Vec3::Zero()) : model.scene.gravity;
    world_ = std::make_unique<RigidWorld>(
        model.scene.bodies,
        rigid_obstacles(model, state, static_cast<double>(state.step) * options.step), gravity,
        magnetics_ == nullptr, model.scene.rigid_iterations);
    world_->restore(state.rigid);
  }
  limits_in_solve_ = integrator_->implicit() && model.scene.limits.in_solve &&
                     model.scene.limits.method != "edges";
  if (!model.cloth.strain_limits.empty())
    limiter_ = std::make_unique<StrainLimiter>(
        LimitedCloth{n, model.cloth.triangles, model.cloth.corners, model.cloth.strain_limits,
                     model.cloth.strain_limit_of, model.cloth.mass, model.cloth.pinned},
        model.scene.limits, &layout.communicator());
  fixed_ = model.cloth.pinned;
  fixed_.resize(model.n_rows(), 0);
  inverse_mass_ = Vector::Zero(model.collision.n_vertices);
  for (Index i = 0; i < n; ++i)
    inverse_mass_[i] = model.cloth.pinned[i] ? 0.0 : 1.0 / model.cloth.mass[i];
}

void Stepper::advance(State& state, StepOutcome& outcome) {
  State& start = outcome.start;
  state.rigid.manifolds
      .clear();  // of the last time the world was built anew: of no use until it is again
  start = state;
  if (world_) world_->save(start.rigid);
  StepReport& report = outcome.report;
  report = StepReport{};
  report.step = state.step + 1;
  report.time = static_cast<double>(state.step + 1) * options_.step;
  report.substeps = 0;
  std::fill(busy_.begin(), busy_.end(), 0.0);
  outcome.contact.assign(model_.cloth.n_vertices, 0);
  outcome.forced.clear();
  outcome.broken.clear();
  try {
    std::vector<StepPart> left = {StepPart{}};  // the last comes first
    State before;                               // of the part; `start` until a part is done
    bool halving = true;  // until 1/64 has failed: then the rest is taken as it comes
    bool halving_for_limits = true, halving_for_motion = true;
    while (!left.empty()) {
      const StepPart part = left.back();
      left.pop_back();
      Left undone;
      bool solved = true;
      const StepReport had = report;
      const std::vector<std::uint8_t> contact = outcome.contact;
      try {
        undone = take(state, outcome, part);
      } catch (const StepFailure&) {
        if (part.length() == 1) throw;
        solved = false;
      }
      // Sweeps alone converge too slowly to be worth more: what they leave is reported.
      const bool worth = undone.stopped || limits_in_solve_ || part.length() > StepPart::quarter;
      const bool failed_limits =
          (undone.stopped || undone.broke_limits) && halving_for_limits && worth;
      const bool froze = undone.froze && halving_for_motion && part.length() > StepPart::quarter;
      if (!solved || froze ||
          (part.length() > 1 && ((undone.impacts > 0 && halving) || failed_limits))) {
        state = report.substeps == 0 ? start : before;
        if (world_) world_->restore(state.rigid);
        forget_steps(state.cloth);
        take_back(had, report);
        outcome.contact = contact;
        const int middle = part.first + part.length() / 2;
        left.push_back({middle, part.last});
        left.push_back({part.first, middle});
        continue;
      }
      if (undone.impacts > 0) halving = false;
      if (undone.stopped || undone.broke_limits) halving_for_limits = false;
      if (undone.froze) halving_for_motion = false;
      report.unresolved += undone.impacts;
      ++report.substeps;
      if (part.length() < StepPart::whole) forget_steps(state.cloth);
      if (left.empty()) break;
      before = state;
      if (world_) world_->save(before.rigid);
    }
    report.busy_least = *std::min_element(busy_.begin(), busy_.end());
    report.busy_mean =
        std::accumulate(busy_.begin(), busy_.end(), 0.0) / static_cast<double>(busy_.size());
    report.busy_most = *std::max_element(busy_.begin(), busy_.end());
    StageTimer timer(report, StageName::Check);
    ++state.step;
    check(state, "certify");
    if (report.unresolved > 0) state.tangled = 2;
    if (collision_ && state.tangled) count_intersections(state, outcome);
    measure_contacts(start.cloth, state, outcome);
    // A world rebuilt from State at fixed steps: what comes after depends on State alone,
    // checkpoint or not.
    if (world_ && state.step % model_.scene.rigid_rebuild_interval == 0) {
      world_->save(state.rigid);
      world_->restore(state.rigid);
    }
  } catch (const SolverFailure& failure) {
    state = start;
    if (world_) world_->restore(state.rigid);
    std::ostringstream out;
    out << "step " << report.step << " (to time " << report.time
        << " s) failed: " << failure.what();
    throw SolverFailure(out.str());
  }
}

Stepper::Left Stepper::take(State& state, StepOutcome& outcome, StepPart part) {
  StepReport& report = outcome.report;
  const auto time = [&](int place) {
    return (static_cast<double>(state.step) + static_cast<double>(place) / StepPart::whole) *
           options_.step;
  };
  step_ = options_.step * part.length() / StepPart::whole;
  start_time_ = time(part.first);
  end_time_ = time(part.last);
  limit_key_ = static_cast<std::uint64_t>(state.step) * StepPart::whole +
               static_cast<std::uint64_t>(part.first);
  share_ = static_cast<double>(part.length()) / (StepPart::whole - part.first);
  {
    StageTimer timer(report, StageName::Loads);
    loads(state);
  }
  {
    StageTimer timer(report, StageName::Proximity);
    contacts_.clear();
    terms_.clear();
    report.contact_energy = 0.0;
    if (collision_) collision_->forget_tangle();
    if (collision_ && state.tangled) collision_->find_tangle(x0_);
    if (collision_) contacts_ = collision_->proximity(collision_team_, x0_);
    if (collision_ && contacts_in_solve_) {
      collision_->terms(contacts_, x0_, v0_, last_change_, state.rigid.positions, step_,
                        model_.cloth.n_vertices, state.contacts, terms_, report.contact_energy);
    }
    n_contact_terms_ = terms_.size();
    if (collision_ && contacts_in_solve_)
      collision_->untangle(x0_, v0_, state.rigid.positions, step_, model_.cloth.n_vertices, terms_);
    if (integrator_->implicit()) add_attachments(state, terms_);
    report.contacts = std::max(report.contacts, static_cast<std::int64_t>(contacts_.size()));
  }
  {
    StageTimer timer(report, StageName::Integrate);
    integrate(state, report);
    check(state, "integrate");  // collision detection takes finite positions for granted
  }
  {
    StageTimer timer(report, StageName::Bodies);
    bodies(state, report);
  }
  Left undone;
  {
    StageTimer timer(report, StageName::Certify);
    undone = limit_and_certify(state, outcome);
  }
  limit_strain_rate(state, outcome);
  return undone;
}

// Velocities of all that collides at the start, and what the last step has changed, which is
// expected of this one: sliding contacts lag behind less.
void Stepper::expect_motion(const State& state) {
  const Index n = model_.cloth.n_vertices;
  v0_.resize(x0_.rows(), 3);
  last_change_.resize(x0_.rows(), 3);
  const bool has_change = state.cloth.last_change.rows() == model_.n_rows();
  parallel_for(team_, n, [&](Index i) {
    v0_.row(i) = state.cloth.v.row(i);
    if (fixed_[i]) v0_.row(i) = (target_.row(i) - x0_.row(i)) / step_;
    last_change_.row(i).setZero();
    if (has_change) last_change_.row(i) = state.cloth.last_change.row(i);
  });
  last_change_.bottomRows(x0_.rows() - n).setZero();
  for (std::size_t b = 0; b < model_.bodies.size(); ++b)
    for (Index i = 0; i < model_.bodies[b].local.rows(); ++i) {
      const Index vertex = model_.bodies[b].first + i;
      v0_.row(vertex) =
          velocity_at(state.rigid, static_cast<Index>(b), x0_.row(vertex).transpose()).transpose();
    }
  v0_.bottomRows(next_obstacles_.rows()) = (next_obstacles_ - state.obstacle_vertices) / step_;
}

// Forces at the start, and where scripted motion leads.
void Stepper::loads(const State& state) {
  const Index n = model_.cloth.n_vertices;
  const double h = step_;
  const Index begin = std::min(layout_.begin(), n), end = std::min(layout_.end(), n);
  if (n > 0) collision_vertices(model_, state, x0_);
  pin_targets(model_, state, end_time_, share_, target_);
  obstacle_vertices(model_, state, end_time_, share_, next_obstacles_);
  if (collision_ && contacts_in_solve_) expect_motion(state);

  force_ = state.external_force;
  parallel_for(team_, end - begin, [&](Index i) {
    force_.row(begin + i) += model_.cloth.mass[begin + i] * model_.scene.gravity.transpose();
  });
  add_drag(team_, model_.scene.air, start_time_, model_.cloth.triangles,
           model_.cloth.triangles_of_vertex.start, model_.cloth.triangles_of_vertex.items,
           state.cloth.x, state.cloth.v, begin, end, force_);

  body_blocks_.clear();
  start_poses_.clear();
  body_velocity_ = Points::Zero(2 * model_.n_bodies(), 3);
  std::vector<Wrench> magnetic(model_.n_bodies());
  if (magnetics_ && n > 0)
    magnetic = magnetics_->wrenches(team_, state.rigid,
                                    obstacle_places(model_, state, start_time_, 0.0).poses,
                                    coil_currents(model_, state, start_time_));
  for (Index b = 0; b < model_.n_bodies(); ++b) {
    start_poses_.push_back(body_pose(state.rigid, b));
    body_blocks_.push_back(model_.body_mass[b].mass * Mat3::Identity());
    body_blocks_.push_back(
        world_inertia(model_.body_mass[b], state.rigid.orientations.row(b).transpose()));
    // What the rigid stage will do by itself is in the prediction, so that the solve adds only what
    // the cloth does.
    body_velocity_.row(2 * b) = state.rigid.velocities.row(b) +
                                h * model_.scene.gravity.transpose() +
                                h / model_.body_mass[b].mass * magnetic[b].force.transpose();
    body_velocity_.row(2 * b + 1) =
        state.rigid.angular_velocities.row(b) +
        h * (body_blocks_[2 * b + 1].inverse() * magnetic[b].torque).transpose();
  }
}

// Attached vertices: a stiff spring between the vertex and its point of the body, both ways.
void Stepper::add_attachments(const State& state, ExtraTerms& terms) const {
  for (const Model::Attached& attached : model_.attachments) {
    const Vec3 point = to_world(state.rigid, attached.body, attached.local);
    ExtraTerm term;
    const Index row = model_.cloth.n_vertices + 2 * attached.body;
    term.entries[0] = {attached.row, false, 1.0, Vec3::Zero()};
    term.entries[1] = {row, false, -1.0, Vec3::Zero()};
    term.entries[2] = {row + 1, true, -1.0,
                       point - state.rigid.positions.row(attached.body).transpose()};
    term.n_entries = 3;
    term.gradient =
        model_.attachment_stiffness * (state.cloth.x.row(attached.row).transpose() - point);
    term.hessian = model_.attachment_stiffness * Mat3::Identity();
    terms.push_back(term);
  }
}

// All terms where cloth and bodies have moved since the start of the step; for Newton loops.
double Stepper::terms_at(const Points& displacement, double time, TermRequest request,
                         ExtraTerms& terms) {
  double energy = n_contact_terms_ > 0
                      ? collision_->terms_at(collision_team_, displacement, time, request, terms)
                      : 0.0;
  for (std::size_t i = n_contact_terms_; i < terms.size(); ++i)
    energy += terms[i].move_linearly(displacement, time);
  return energy;
}

void Stepper::integrate(State& state, StepReport& report) {
  const Index n = model_.cloth.n_vertices;
  if (n == 0) return;
  const EndOfLimitPhase end{*elasticity_};
  const bool all = integrator_->asks_energy();
  if (limits_in_solve_) {
    const Index first = all ? 0 : std::min(layout_.begin(), n),
                last = all ? n : std::min(layout_.end(), n);
    elasticity_->enter_limit_phase(team_, state.cloth.x, first, last);
  }
  StepInputs inputs;
  inputs.step = step_;
  inputs.time = start_time_;
  inputs.force = &force_;
  inputs.terms = &terms_;
  const TermsAt at = [this](const Points& displacement, double after, TermRequest request,
                            ExtraTerms& terms) {
    return terms_at(displacement, after, request, terms);
  };
  inputs.terms_at = &at;
  const FrictionAt friction = [this](const Points& displacement, double after, ExtraTerms& terms) {
    return collision_->friction_at(team_, displacement, after, inverse_mass_,
                                   model_.cloth.n_vertices, terms);
  };
  if (n_contact_terms_ > 0) inputs.friction_at = &friction;
  inputs.fixed = &fixed_;
  inputs.target = &target_;
  inputs.body_mass = &body_blocks_;
  predicted_body_velocity_ = body_velocity_;
  IntegrationReport done;
  try {
    done = integrator_->advance(team_, layout_, inputs, state.cloth, body_velocity_);
  } catch (const NewtonFailure& failure) {
    std::ostringstream out;
    out << failure.what() << "; the residual is largest at cloth vertex "
        << vertex_of_row(failure.row) << ", which began the step at (" << x0_.row(failure.row)
        << ')';
    throw NewtonFailure(out.str(), failure.row);
  }
  report.newton_iterations += done.newton_iterations;
  report.linear_iterations += done.linear_iterations;
  report.linear_residual = done.residual;
}

// What the cloth did to the bodies goes to Bullet as impulses; it adds loads and contacts among
// bodies.
void Stepper::bodies(State& state, StepReport& report) {
  if (!world_) return;
  Points impulses = Points::Zero(model_.n_bodies(), 3), angular = impulses;
  if (model_.cloth.n_vertices > 0)
    for (Index b = 0; b < model_.n_bodies(); ++b) {
      impulses.row(b) = model_.body_mass[b].mass *
                        (body_velocity_.row(2 * b) - predicted_body_velocity_.row(2 * b));
      angular.row(b) =
          (body_blocks_[2 * b + 1] *
           (body_velocity_.row(2 * b + 1) - predicted_body_velocity_.row(2 * b + 1)).transpose())
              .transpose();
    }
  const ObstaclePlaces places = obstacle_places(model_, state, end_time_, share_);
  if (!magnetics_) return world_->advance(step_, impulses, angular, places, state.rigid);
  const MagneticMotion::Done done = magnetics_->advance(
      team_, step_, impulses, angular, obstacle_places(model_, state, start_time_, 0.0), places,
      start_time_, *world_, state.rigid, state.circuits, state.induced_moments);
  report.magnetic_substeps += done.substeps;
  report.magnetic_error = done.error;
}

std::vector<Wrench> Stepper::magnetic_forces(const State& state) const {
  if (!magnetics_) return std::vector<Wrench>(model_.n_bodies());
  const double time = static_cast<double>(state.step) * options_.step;
  return magnetics_->wrenches(team_, state.rigid, obstacle_places(model_, state, time, 0.0).poses,
                              coil_currents(model_, state, time));
}

double Stepper::magnetic_energy(const State& state) const {
  const double time = static_cast<double>(state.step) * options_.step;
  return magnetics_ ? magnetics_->energy(team_, state.rigid,
                                         obstacle_places(model_, state, time, 0.0).poses,
                                         state.induced_moments)
                    : 0.0;
}

Index Stepper::vertex_of_row(Index row) const {
  return static_cast<Index>(
      std::find(model_.row_of_vertex.begin(), model_.row_of_vertex.end(), row) -
      model_.row_of_vertex.begin());
}

// A step that moves a vertex by a hundred times the size of what there is has diverged, finite or
// not.
void Stepper::check(const State& state, const char* stage) const {
  double most = 100.0 * model_.cloth_size;
  Index worst = -1;
  for (Index i = 0; i < model_.cloth.n_vertices; ++i) {
    const double moved = (state.cloth.x.row(i) - x0_.row(i)).norm();
    const bool finite = std::isfinite(moved) && state.cloth.v.row(i).allFinite();
    if (moved > most || (worst < 0 && !finite)) {
      worst = i;
      most = std::fmax(most, moved);
    }
  }
  if (worst < 0) return;
  std::ostringstream out;
  out << "cloth vertex " << vertex_of_row(worst) << " moved by "
      << (state.cloth.x.row(worst) - x0_.row(worst)).norm() << " m in the stage \"" << stage
      << "\", more than 100 times the size of the cloths, or is not finite; shorten "
         "integrator.step";
  throw SolverFailure(out.str());
}

}  // namespace loomstone
