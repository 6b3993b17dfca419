#include "core/sim/step/limit_and_certify.h"

#include <algorithm>
#include <cmath>

#include "core/sim/model/motion.h"
#include "core/sim/step/energies.h"
#include "core/sim/step/limits_with_contacts.h"

namespace loomstone {

namespace {

// Certification and fallbacks withhold too much of the motion of a part if they withhold more than
// this fraction of ConstrainReport::requested. Bisection::judge() then halves the part, unless it
// is at most a quarter of the step long or such a part of this step has already been accepted with
// too much withheld motion. Our choice.
constexpr double much_withheld = 0.1;

// Returns the motions of bodies that certification checks. The motion of a body leads from its pose
// at the start of the part to its pose after the stage that moves bodies.
FreeBodies free_bodies(const Loads& loads, const State& state, const Engines& engines) {
  const Model& model = engines.model;
  FreeBodies bodies(model.n_bodies());
  const std::vector<std::uint8_t> supported =
      engines.world ? engines.world->supported() : std::vector<std::uint8_t>();
  for (Index b = 0; b < model.n_bodies(); ++b) {
    FreeBody& body = bodies[b];
    body.surface = model.collision.surface_of_vertex(model.bodies[b].first);
    body.local = &model.bodies[b].local;
    body.inverse_mass = 1.0 / model.body_mass[b].mass;
    body.inverse_inertia = loads.body_mass[2 * b + 1].inverse();
    body.supported = supported[b] != 0;
    body.velocity = state.rigid.velocities.row(b).transpose();
    body.angular_velocity = state.rigid.angular_velocities.row(b).transpose();
    body.start = loads.body_poses[b];
    body.end = body_pose(state.rigid, b);
  }
  return bodies;
}

// Moves the cloth to x1. Adds to its velocities the displacement, without the corrections `at_rest`
// (see ConstrainReport), divided by the length of the part. If any vertex moves, notes this in
// `certified`, stores the previous positions and velocities there, and restarts multistep schemes.
void move_cloth(const StepContext& part, const Points& x1, const Points& at_rest, ClothState& cloth,
                Certified& certified) {
  if (x1.topRows(cloth.x.rows()) == cloth.x) return;  // the usual case
  certified.moved = true;
  certified.solved_x = cloth.x, certified.solved_v = cloth.v;
  for (Index i = 0; i < cloth.x.rows(); ++i) {
    if (x1.row(i) == cloth.x.row(i)) continue;
    cloth.v.row(i) += (x1.row(i) - cloth.x.row(i)) / part.h;
    if (at_rest.rows() > 0) cloth.v.row(i) -= at_rest.row(i) / part.h;
    cloth.x.row(i) = x1.row(i);
  }
  cloth.restart_multistep();
}

// Sets the certified poses of the bodies, and adds the corrections FreeBody::moved and turned,
// divided by the length of the part, to their velocities. The rigid-body world reads poses and
// velocities in its next step.
void move_bodies_with(const StepContext& part, const FreeBodies& bodies, RigidState& rigid) {
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const FreeBody& body = bodies[i];
    const Index b = static_cast<Index>(i);
    rigid.positions.row(b) = body.end.position.transpose();
    rigid.orientations.row(b) = body.end.orientation.transpose();
    rigid.velocities.row(b) += body.moved.transpose() / part.h;
    rigid.angular_velocities.row(b) += body.turned.transpose() / part.h;
  }
}

// Returns the largest speed of a prescribed vertex or of a vertex of an obstacle [m/s].
double scripted_speed(const StepContext& part, const Points& x0, const Points& x1,
                      const Model& model) {
  double square = 0.0;
  const auto include = [&](Index i) {
    square = std::max(square, (x1.row(i) - x0.row(i)).squaredNorm());
  };
  for (const CollisionSurface& surface : model.collision.surfaces)
    if (surface.kind != CollisionSurface::Kind::Body)
      for (Index i = surface.first_vertex; i < surface.first_vertex + surface.n_vertices; ++i)
        if (!(model.inverse_mass[i] > 0.0)) include(i);
  return std::sqrt(square) / part.h;
}

// Returns the vertices of the cloths that sweeps must not move, because sweeps would push them into
// other surfaces. These cloths are loaded by bodies (sweeps ignore the mass of bodies), or their
// limits are forced (see NearContacts). Only the limit phases of the solve limit their strain.
std::vector<Index> loaded_vertices(const Model& model, const NearContacts& near) {
  const CollisionModel& collision = model.collision;
  std::vector<std::uint8_t> loaded = loaded_by_bodies(model, near.totals);
  for (std::size_t s = 0; s < near.forced.size(); ++s) loaded[s] |= near.forced[s];
  std::vector<Index> vertices;
  for (std::size_t s = 0; s < loaded.size(); ++s)
    if (const CollisionSurface& cloth = collision.surfaces[s];
        loaded[s] && cloth.kind == CollisionSurface::Kind::Cloth)
      for (Index i = 0; i < cloth.n_vertices; ++i) vertices.push_back(cloth.first_vertex + i);
  return vertices;
}

// Returns the energy of the cloth at the end of the part, if it moves from `solved`, its state
// after the solve, to x1, and the corrections `at_rest` do not change velocities.
ClothEnergy cloth_energy(const StepContext& part, const ClothState& solved, const Points& x1,
                         const Points& at_rest, const Engines& engines) {
  const Points x = x1.topRows(solved.x.rows());
  Points v = solved.v + (x - solved.x) / part.h;
  if (at_rest.rows() > 0) v -= at_rest / part.h;
  return {kinetic_energy(engines, v), potential_energy(engines, x)};
}

void add_to_report(const StepContext& part, const ConstrainReport& done, bool limited,
                   StepReport& report) {
  report.seconds.limit += done.limit_seconds;
  report.seconds.certify -= done.limit_seconds;
  // Stepper::collide() counts all waiting in this stage as waiting in collision handling. These
  // lines exclude the waiting in strain limiting.
  report.ranks.collision_waiting -= done.limit_waiting;
  report.ranks.collision_computing += done.limit_waiting;
  report.limits.sweeps += done.limits.sweeps;
  report.limits.evaluations += done.limits.evaluations;
  if (limited) report.limits.rounds = std::max(report.limits.rounds, done.rounds);
  report.limits.fallbacks += done.fallbacks;
  report.withheld.requested += done.requested;
  report.contacts.impacts += done.certified.impacts;
  report.withheld.vertices += done.certified.n_withheld();
  report.withheld.motion += done.certified.withheld_length();
  report.withheld.momentum += done.certified.withheld_moment() / part.h;
}

void move_obstacles(const Points& next, State& state) {
  if (std::ranges::find(state.pose_override, 1) != state.pose_override.end())
    state.previous_obstacle_vertices = state.obstacle_vertices;
  else
    state.previous_obstacle_vertices.resize(0, 3);
  state.obstacle_vertices = next;
}

}  // namespace

Certified limit_and_certify(const StepContext& part, const Loads& loads, NearContacts& near,
                            State& state, Engines& engines, StepOutcome& outcome) {
  const Model& model = engines.model;
  const Index n = model.cloth.n_vertices;
  move_obstacles(loads.next_obstacles, state);
  const auto mark = [&](const std::array<Index, 4>& vertices) {
    for (const Index vertex : vertices)
      if (vertex < n) outcome.contact[vertex] = 1;
  };
  if (!engines.contacts_in_solve)
    for (const Contact& contact : near.contacts) mark(contact.vertices);
  for (const std::array<Index, 4>& vertices : near.touching) mark(vertices);
  StrainLimiter* const limiter = engines.limits_after_solve ? engines.limiter.get() : nullptr;
  if (n == 0 || (!engines.collision && !limiter)) return {};
  Points x1;
  collision_vertices(model, state, x1);
  FreeBodies bodies = free_bodies(loads, state, engines);
  ConstrainInputs inputs;
  inputs.team = &engines.team, inputs.collision_team = &engines.collision_team,
  inputs.ranks = &engines.layout.communicator();
  inputs.cloth = &model.cloth;
  inputs.limiter = limiter;
  inputs.collision = engines.collision.get();
  inputs.tangle = &near.tangle;
  inputs.limits_hold = model.scene.limits.method != LimitMethod::Edges;
  inputs.limits_in_solve = engines.limits_in_solve;
  if (inputs.limits_in_solve) inputs.loaded = loaded_vertices(model, near);
  if (!engines.contacts_in_solve) inputs.repelled = &near.repelled;
  inputs.seed = part.seed, inputs.h = part.h;
  inputs.x0 = &loads.x0;
  inputs.inverse_mass = &model.inverse_mass;
  if (limiter) inputs.scripted_speed = scripted_speed(part, loads.x0, x1, model);
  const ClothState& solved = state.cloth;
  inputs.x = &solved.x, inputs.v = &solved.v;
  inputs.energy = [&](const Points& x1, const Points& at_rest) {
    return cloth_energy(part, solved, x1, at_rest, engines);
  };
  inputs.largest_kinetic = state.account.largest_kinetic;
  const ConstrainReport done = constrain(inputs, x1, bodies);
  Certified certified;
  certified.limited = done.limited;
  move_cloth(part, x1, done.at_rest, state.cloth, certified);
  move_bodies_with(part, bodies, state.rigid);
  for (const Index i : done.touched) outcome.contact[i] = 1;
  if (engines.collision && engines.contacts_in_solve) {
    near.energy = engines.collision->update_anchors(near.contacts, near.contact_terms, loads.x0, x1,
                                                    state.contacts);
    // Every rank has the anchors of all contacts.
    for (const ContactState::Anchor& anchor : state.contacts.anchors)
      mark(pair_vertices(model.collision, anchor.kind, pair_key(anchor.a, anchor.b)));
  }
  add_to_report(part, done, limiter != nullptr, outcome.report);
  certified.result.impacts = done.certified.unresolved;
  certified.result.withheld_much =
      done.certified.withheld_length() > much_withheld * done.requested;
  certified.result.broke_limits = done.broke_limits;
  certified.result.stopped_for_limits = done.stopped_for_limits;
  if (limiter && done.touched.empty() && !inputs.repelled) certified.limits = done.limits;
  return certified;
}

}  // namespace loomstone
