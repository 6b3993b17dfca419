// How a step ends: strains within their limits, the way free of impacts, velocities that follow,
// and what is reported.
#include <cmath>

#include "core/sim/model/motion.h"
#include "core/sim/step/constrain.h"
#include "core/sim/step/stage_timer.h"
#include "core/sim/step/stepper.h"

namespace loomstone {

// Of the motion wanted, by truncation. Our choice: scenes withhold 1e-5 or nothing in all steps but
// a few, which withhold all.
constexpr double much_withheld = 0.1;

// The last stage: velocities lead the next step away from the limits no faster than they may;
// positions stay.
void Stepper::limit_strain_rate(State& state, StepOutcome& outcome) {
  if (!limiter_) return;
  StepReport& report = outcome.report;
  StageTimer timer(report, StageName::Limit);
  if (!left_) left_ = limiter_->measure(team_, state.cloth.x);
  const LimitReport& left = *left_;
  report.weft_excess = left.excess[0];
  report.warp_excess = left.excess[1];
  report.shear_excess = left.excess[2];
  report.beyond_limit = left.beyond;
  report.worst_element = left.worst < 0 ? -1 : model_.triangle_of[left.worst];
  outcome.broken = left.broken;
  report.broken_limits = static_cast<std::int64_t>(left.broken_elements().size());
  report.rate_sweeps +=
      limiter_->enforce_rate(team_, limit_key_, state.cloth.x, step_, state.cloth.v, false).sweeps;
}

// The cloth goes to x1_ and its velocities with it; what did not move keeps the integrator's.
void Stepper::move_cloth(State& state) {
  bool any = false;
  for (Index i = 0; i < model_.cloth.n_vertices; ++i) {
    if (x1_.row(i) == state.cloth.x.row(i)) continue;
    any = true;
    state.cloth.v.row(i) += (x1_.row(i) - state.cloth.x.row(i)) / step_;
    state.cloth.x.row(i) = x1_.row(i);
  }
  if (any) state.cloth.forget_history();  // multi-step schemes start again after a jump of velocity
}

// The bodies as certification may move them: from where they were to where Bullet has put them.
FreeBodies Stepper::free_bodies(const State& state) const {
  FreeBodies bodies(model_.n_bodies());
  const std::vector<std::uint8_t> supported =
      world_ ? world_->supported() : std::vector<std::uint8_t>();
  for (Index b = 0; b < model_.n_bodies(); ++b) {
    FreeBody& body = bodies[b];
    body.surface = model_.collision.surface_of_vertex[model_.bodies[b].first];
    body.local = &model_.bodies[b].local;
    body.inverse_mass = 1.0 / model_.body_mass[b].mass;
    body.inverse_inertia = body_blocks_[2 * b + 1].inverse();
    body.supported = supported[b] != 0;
    body.start = start_poses_[b];
    body.end = body_pose(state.rigid, b);
  }
  return bodies;
}

// Strains within their limits, and (the last thing that moves vertices) no impact on the way from
// x0 to x1, no intersection at x1. Velocities get the mean of what that takes over the step,
// (3.16).
Stepper::Left Stepper::limit_and_certify(State& state, StepOutcome& outcome) {
  StepReport& report = outcome.report;
  const Index n = model_.cloth.n_vertices;
  state.obstacle_vertices = next_obstacles_;
  for (const Contact& contact : contacts_)
    for (const Index vertex : contact.vertices)
      if (vertex < n) outcome.contact[vertex] = 1;
  left_.reset();
  if (n == 0 || (!collision_ && !limiter_)) return {};
  collision_vertices(model_, state, x1_);
  FreeBodies bodies = free_bodies(state);
  ConstrainInputs inputs;
  inputs.team = &team_;
  inputs.collision_team = &collision_team_;
  inputs.cloth = &model_.cloth;
  inputs.limiter = limiter_.get();
  inputs.collision = collision_.get();
  inputs.limits_hold = model_.scene.limits.method != "edges";
  if (!contacts_in_solve_) inputs.repelled = &contacts_;
  inputs.key = limit_key_;
  inputs.step = step_;
  inputs.x0 = &x0_;
  inputs.inverse_mass = &inverse_mass_;
  const ConstrainReport done = constrain(inputs, x1_, bodies);
  move_cloth(state);
  if (done.touched.empty() && !inputs.repelled) left_ = done.limits;  // nothing has moved since
  for (const Index i : done.touched) outcome.contact[i] = 1;
  for (Index b = 0; b < model_.n_bodies();
       ++b) {  // Bullet takes over what has changed with its next step
    const FreeBody& body = bodies[b];
    state.rigid.positions.row(b) = body.end.position.transpose();
    state.rigid.orientations.row(b) = body.end.orientation.transpose();
    state.rigid.velocities.row(b) += body.moved.transpose() / step_;
    state.rigid.angular_velocities.row(b) += body.turned.transpose() / step_;
  }
  if (collision_ && contacts_in_solve_)
    collision_->update_anchors(contacts_, x0_, x1_, state.contacts);
  report.seconds[static_cast<int>(StageName::Limit)] += done.limit_seconds;
  report.seconds[static_cast<int>(StageName::Certify)] -= done.limit_seconds;
  report.limit_sweeps += done.limits.sweeps;
  report.limit_evaluations += done.limits.evaluations;
  if (limiter_) report.limit_rounds = std::max(report.limit_rounds, done.rounds);
  report.limit_retreats += done.retreats;
  report.limit_excess = std::max(report.limit_excess, done.limits.largest());
  report.wanted_motion += done.wanted;
  report.impacts += done.certified.impacts;
  report.truncated += done.certified.truncated();
  report.withheld_motion += done.certified.withheld();
  report.truncated_momentum += done.certified.withheld_moment() / step_;
  const bool froze = done.certified.withheld() > much_withheld * done.wanted;
  return {done.certified.unresolved, froze, done.broke, done.stopped};
}

// How free the cloth is where a step has left impacts: never hidden, and counted until it is free
// again.
void Stepper::count_intersections(State& state, StepOutcome& outcome) {
  collision_vertices(model_, state, x1_);
  const std::vector<std::array<Index, 2>> pairs = cloth_intersections(model_.collision, x1_);
  outcome.report.intersections = static_cast<std::int64_t>(pairs.size());
  // An edge may also pierce a triangle that it shares a corner's triangle with: not a pair that is
  // counted.
  if (pairs.empty() && collision_->find_tangle(x1_) == 0) state.tangled = 0;
  if (state.tangled != 2) return;
  outcome.forced = pairs;
  outcome.report.forced = outcome.report.intersections;
  for (const auto& pair : pairs)
    for (const Index triangle : pair)
      for (int k = 0; k < 3; ++k)
        if (const Index v = model_.collision.triangles(triangle, k); v < model_.cloth.n_vertices)
          outcome.contact[v] = 2;
}

// What certification took from the step, and how calm contact is.
void Stepper::measure_contacts(const ClothState& before, const State& state, StepOutcome& outcome) {
  StepReport& report = outcome.report;
  report.withheld =
      report.wanted_motion > 0.0 ? report.withheld_motion / report.wanted_motion : 0.0;
  double squares = 0.0;
  std::int64_t count = 0;
  for (Index i = 0; i < model_.cloth.n_vertices; ++i) {
    if (outcome.contact[i] == 0 || fixed_[i]) continue;
    squares += (state.cloth.v.row(i) - before.v.row(i)).squaredNorm();
    ++count;
  }
  report.contact_acceleration =
      count > 0 ? std::sqrt(squares / static_cast<double>(count)) / options_.step : 0.0;
}

}  // namespace loomstone
