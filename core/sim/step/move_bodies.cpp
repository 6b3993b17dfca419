#include "core/sim/step/move_bodies.h"

#include <algorithm>
#include <array>

#include "core/base/rotation.h"
#include "core/sim/model/motion.h"
#include "core/sim/step/energies.h"

namespace loomstone {

namespace {

// If bodies carry no attached vertex farther than this fraction of Model::cloth_size from where the
// integrator has placed it, carried_gain is 0, because such distances are rounding errors. Our
// choice.
constexpr double rounding_of_places = 1e-10;

// Returns the impulses that change the momenta of the bodies from those at the velocities `before`
// (2 b x 3) to those at the velocities in `solved`. If the integrator has moved the bodies, their
// inertia in world axes has changed with their orientation. All impulses are 0 without cloth.
BodyImpulses solved_impulses(const Loads& loads, const Points& before, const SolvedBodies& solved,
                             const Model& model) {
  BodyImpulses impulses{Points::Zero(model.n_bodies(), 3), Points::Zero(model.n_bodies(), 3)};
  if (model.cloth.n_vertices == 0) return impulses;
  const Points& after = solved.velocity;
  for (Index b = 0; b < model.n_bodies(); ++b) {
    impulses.linear.row(b) = model.body_mass[b].mass * (after.row(2 * b) - before.row(2 * b));
    const Mat3& inertia = loads.body_mass[2 * b + 1];
    const Vec3 start = before.row(2 * b + 1).transpose(), end = after.row(2 * b + 1).transpose();
    const Vec3 angular =
        solved.poses.empty()
            ? Vec3(inertia * (end - start))
            : Vec3(world_inertia(model.body_mass[b], solved.poses[b].orientation) * end -
                   inertia * start);
    impulses.angular.row(b) = angular.transpose();
  }
  return impulses;
}

// Returns the impulses that the cloth and the user's forces exert on the bodies.
BodyImpulses given_impulses(const Loads& loads, const SolvedBodies& solved, const Model& model) {
  BodyImpulses impulses = solved_impulses(loads, loads.body_velocity, solved, model);
  for (Index b = 0; b < model.n_bodies(); ++b) {
    impulses.linear.row(b) += loads.body_impulse.row(2 * b);
    impulses.angular.row(b) += loads.body_impulse.row(2 * b + 1);
  }
  return impulses;
}

// Returns the bodies to which vertices are attached and, if the integrator has moved the bodies,
// those that cloth has pushed, in ascending order.
std::vector<Index> bodies_with_cloth(const SolvedBodies& solved, const Model& model) {
  std::vector<Index> bodies;
  for (std::size_t b = 0; b < solved.with_cloth.size(); ++b)
    if (solved.with_cloth[b]) bodies.push_back(static_cast<Index>(b));
  for (const AttachedVertex& attached : model.attachments) bodies.push_back(attached.body);
  std::sort(bodies.begin(), bodies.end());
  bodies.erase(std::unique(bodies.begin(), bodies.end()), bodies.end());
  return bodies;
}

// Returns the pose of body b at the end of the part, if the bodies keep the given velocities
// (2 b x 3) in the part.
RigidPose pose_at(const StepContext& part, const Loads& loads, const Points& velocities, Index b) {
  const RigidPose& from = loads.body_poses[b];
  const Vec3 speed = velocities.row(2 * b).transpose(),
             rate = velocities.row(2 * b + 1).transpose();
  return {from.position + part.h * speed, turned(from.orientation, rate, part.h)};
}

// Divides the impulses of the cloth and of the user's forces in a part into impulses at its start
// and impulses at its end, and returns them in this order. Without contacts and under constant
// magnetic forces, the bodies in bodies_with_cloth() then get the final velocities and the poses
// that the integrator has computed. If the integrator has computed no poses, these bodies move by
// their final velocities times the length of the part. On other bodies, all impulses act at the
// start.
std::array<BodyImpulses, 2> divided_impulses(const StepContext& part, const Loads& loads,
                                             const SolvedBodies& solved, const RigidState& rigid,
                                             const Model& model) {
  BodyImpulses first = given_impulses(loads, solved, model), last = first;
  last.linear.setZero(), last.angular.setZero();
  const Points start = body_velocities(rigid);
  for (const Index b : bodies_with_cloth(solved, model)) {
    const double mass = model.body_mass[b].mass;
    const RigidPose& from = loads.body_poses[b];
    const RigidPose to =
        solved.poses.empty() ? pose_at(part, loads, solved.velocity, b) : solved.poses[b];
    // Momenta at the start plus half of the momenta that gravity and magnetic forces add.
    const Vec3 momentum =
        0.5 * (mass * (start.row(2 * b) + loads.body_velocity.row(2 * b)).transpose() -
               loads.body_impulse.row(2 * b).transpose());
    const Vec3 spin =
        0.5 * (loads.body_mass[2 * b + 1] *
                   (start.row(2 * b + 1) + loads.body_velocity.row(2 * b + 1)).transpose() -
               loads.body_impulse.row(2 * b + 1).transpose());
    const Vec3 turning = angular_velocity_between(from.orientation, to.orientation, part.h);
    const Mat3 inertia =
        world_inertia(model.body_mass[b], turned(from.orientation, turning, 0.5 * part.h));
    const Vec3 linear = mass / part.h * (to.position - from.position) - momentum;
    const Vec3 angular = inertia * turning - spin;
    last.linear.row(b) = first.linear.row(b) - linear.transpose();
    last.angular.row(b) = first.angular.row(b) - angular.transpose();
    first.linear.row(b) = linear.transpose();
    first.angular.row(b) = angular.transpose();
  }
  return {first, last};
}

Vec3 nearest_on_segment(const Vec3& a, const Vec3& b, const Vec3& point) {
  const Vec3 along = b - a;
  const double square = along.squaredNorm();
  return square > 0.0 ? a + std::clamp(along.dot(point - a) / square, 0.0, 1.0) * along : a;
}

// If contacts or varying magnetic forces have changed the motion of bodies, moves attached vertices
// with their points on the bodies. Without this motion, the springs of attachments would bring them
// back in the next part, with a velocity equal to their distance from these points divided by the
// length of that part. Velocities do not change here; the springs exchange momentum between cloth
// and bodies.
//
// A contact that only cancels the acceleration of a body, such as the contact with a floor on which
// the body rests, moves no vertex, because the springs balance the force of this contact. The
// velocities of the body at the start of the part and after the solve would carry the point of a
// vertex to two places. The vertex is therefore moved only by the distance of its point from the
// segment between these two places. touched[b] is 1 if contacts have changed the motion of body b;
// if `touched` is empty, any body may have been touched. A vertex that is attached to several
// bodies moves by the mean. Returns MovedBodies::carried_gain [J].
double shift_attached(const StepContext& part, const Loads& loads, const SolvedBodies& solved,
                      const std::vector<std::uint8_t>& touched, const Engines& engines,
                      State& state) {
  const std::vector<AttachedVertex>& attached = engines.model.attachments;
  const Points start = body_velocities(part.start->rigid);
  std::vector<Vec3> shifts(attached.size(), Vec3::Zero());
  double farthest = 0.0;
  for (std::size_t i = 0; i < attached.size(); ++i) {
    const AttachedVertex& vertex = attached[i];
    if (!touched.empty() && !touched[vertex.body]) continue;
    const auto place = [&](const Points& velocities) -> Vec3 {
      const RigidPose pose = pose_at(part, loads, velocities, vertex.body);
      return pose.position + rotation_matrix(pose.orientation) * vertex.local;
    };
    const Vec3 actual = to_world(state.rigid, vertex.body, vertex.local);
    shifts[i] = actual - nearest_on_segment(place(start), place(solved.velocity), actual);
    farthest = std::max(farthest, shifts[i].norm());
  }
  if (farthest <= rounding_of_places * engines.model.cloth_size) return 0.0;
  Points& x = state.cloth.x;
  const double energy = potential_energy(engines, x);
  for (std::size_t i = 0, end = 0; i < attached.size(); i = end) {
    Vec3 sum = Vec3::Zero();  // attachments are sorted by their rows
    for (end = i; end < attached.size() && attached[end].row == attached[i].row; ++end)
      sum += shifts[end];
    x.row(attached[i].row) += sum.transpose() / static_cast<double>(end - i);
  }
  return potential_energy(engines, x) - energy;
}

// Gives attached vertices the positions and velocities of their points on the bodies. Returns
// MovedBodies::carried_gain [J].
double follow_bodies(const Model& model, const Engines& engines, State& state) {
  ClothState& cloth = state.cloth;
  const auto point = [&](const AttachedVertex& attached) {
    return to_world(state.rigid, attached.body, attached.local);
  };
  double farthest = 0.0;
  for (const AttachedVertex& attached : model.attachments)
    farthest = std::max(farthest, (point(attached) - cloth.x.row(attached.row).transpose()).norm());
  const bool carried = farthest > rounding_of_places * model.cloth_size;
  const double energy = carried ? potential_energy(engines, cloth.x) : 0.0;
  for (const AttachedVertex& attached : model.attachments) {
    const Vec3 place = point(attached);
    cloth.x.row(attached.row) = place.transpose();
    cloth.v.row(attached.row) = velocity_at(state.rigid, attached.body, place).transpose();
  }
  return carried ? potential_energy(engines, cloth.x) - energy : 0.0;
}

// Adds contacts to the motion of the bodies that the integrator has computed under all loads. The
// rigid-body world computes this motion again with contacts. Bodies whose motion no contact changes
// keep the motion of the integrator. Returns the work of scripted obstacles [J].
double move_solved_bodies(const StepContext& part, const Loads& loads, const SolvedBodies& solved,
                          State& state, Engines& engines) {
  const Model& model = engines.model;
  RigidState& rigid = state.rigid;
  const BodyImpulses impulses = solved_impulses(loads, body_velocities(rigid), solved, model);
  std::vector<std::uint8_t> touched;
  engines.world->advance(part.h, impulses, obstacle_places(model, state, part.t1, part.share),
                         rigid, &touched);
  for (Index b = 0; b < model.n_bodies(); ++b) {
    if (touched[b]) continue;
    rigid.positions.row(b) = solved.poses[b].position.transpose();
    rigid.orientations.row(b) =
        nearer_sign(solved.poses[b].orientation, rigid.orientations.row(b).transpose()).transpose();
    rigid.velocities.row(b) = solved.velocity.row(2 * b);
    rigid.angular_velocities.row(b) = solved.velocity.row(2 * b + 1);
  }
  return engines.world->obstacle_work();
}

}  // namespace

MovedBodies move_bodies(const StepContext& part, const Loads& loads, const SolvedBodies& solved,
                        State& state, Engines& engines, StepReport& report) {
  MovedBodies moved;
  if (!engines.world) return moved;
  const Model& model = engines.model;
  std::vector<std::uint8_t> touched;
  if (engines.magnetics) {
    const auto [first, last] = divided_impulses(part, loads, solved, state.rigid, model);
    const ObstaclePlaces start = obstacle_places(model, state, part.t0, 0.0);
    const ObstaclePlaces places = obstacle_places(model, state, part.t1, part.share);
    const MagneticEffort effort =
        engines.magnetics->advance(engines.team, {part.t0, part.h, first, last, start, places},
                                   *engines.world, state.rigid, state.magnetic);
    report.magnets.substeps += effort.substeps;
    report.magnets.force_error = effort.error;
    moved.obstacle_work = effort.obstacle_work;
  } else if (!solved.poses.empty()) {
    moved.obstacle_work = move_solved_bodies(part, loads, solved, state, engines);
  } else {
    const BodyImpulses impulses = given_impulses(loads, solved, model);
    engines.world->advance(part.h, impulses, obstacle_places(model, state, part.t1, part.share),
                           state.rigid, &touched);
    moved.obstacle_work = engines.world->obstacle_work();
  }
  if (!solved.poses.empty())
    moved.carried_gain = follow_bodies(model, engines, state);
  else if (!model.attachments.empty())
    moved.carried_gain = shift_attached(part, loads, solved, touched, engines, state);
  return moved;
}

}  // namespace loomstone
