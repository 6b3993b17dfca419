#include "core/electrodynamics/shared_kicks.h"

#include <algorithm>

namespace loomstone {

namespace {

// Momenta of a body before its kicks at the end of the sub-step, and these kicks.
struct OwnKick {
  Vec3 linear, angular;  // momenta that RigidWorld has returned [kg m/s], [kg m^2/s]
  Vec3 push, twist;      // [N s], [N m s]
};

// Mass [kg] and centre of mass [m] of a group at given poses, and inertia about this centre
// [kg m^2].
struct GroupMass {
  double mass = 0.0;
  Vec3 centre = Vec3::Zero();
  Mat3 inertia = Mat3::Zero();
};

GroupMass group_mass(const MagneticModel& model, const PressedGroup& group,
                     const RigidState& state) {
  GroupMass whole;
  for (const Index b : group.bodies) {
    const double mass = model.bodies[b].mass.mass;
    whole.centre += mass * state.positions.row(b).transpose(), whole.mass += mass;
  }
  whole.centre /= whole.mass;
  for (const Index b : group.bodies) {
    const MassProperties& own = model.bodies[b].mass;
    const Vec3 arm = state.positions.row(b).transpose() - whole.centre;
    whole.inertia += world_inertia(own, state.orientations.row(b).transpose()) +
                     own.mass * (arm.squaredNorm() * Mat3::Identity() - arm * arm.transpose());
  }
  return whole;
}

// Returns the rotation of a group in the sub-step. Bodies that only spin in place do not turn the
// group. If all their centres lie on one line, however, their spins do turn it about this line.
Mat3 turn_of(const MagneticModel& model, const KickedSubstep& substep, const PressedGroup& group,
             const std::vector<OwnKick>& kicks) {
  constexpr double share_of_spins = 1e-6;
  const GroupMass whole = group_mass(model, group, substep.start);
  Vec3 momentum = Vec3::Zero();
  Mat3 inertia = share_of_spins * whole.inertia;
  for (std::size_t k = 0; k < kicks.size(); ++k) {
    const Index b = group.bodies[k];
    const Vec3 arm = substep.start.positions.row(b).transpose() - whole.centre;
    momentum +=
        (1.0 + share_of_spins) * arm.cross(kicks[k].linear) + share_of_spins * kicks[k].angular;
    inertia +=
        model.bodies[b].mass.mass * (arm.squaredNorm() * Mat3::Identity() - arm * arm.transpose());
  }
  const Vec3 spin = inertia.ldlt().solve(momentum);
  return rotation_matrix(quaternion_from_rotation_vector(substep.h * spin));
}

// Returns the OwnKick of each body of a group. The kicks are half of the difference between the
// wrenches at the end and at the start of the sub-step, times its length. The wrenches at the start
// are turned with the group before the difference is taken.
std::vector<OwnKick> own_kicks(const MagneticModel& model, const KickedSubstep& substep,
                               const PressedGroup& group) {
  const RigidState& answer = substep.answer.state;
  std::vector<OwnKick> kicks;
  for (const Index b : group.bodies) {
    const MagneticRotor& body = model.bodies[b];
    kicks.push_back({body.mass.mass * answer.velocities.row(b).transpose(),
                     angular_momentum(body.rotor, substep.start.orientations.row(b).transpose(),
                                      answer.angular_velocities.row(b).transpose()),
                     Vec3::Zero(), Vec3::Zero()});
  }
  const Mat3 turn = turn_of(model, substep, group, kicks);
  for (std::size_t k = 0; k < kicks.size(); ++k) {
    const Wrench &first = substep.first[group.bodies[k]], &second = substep.second[group.bodies[k]];
    kicks[k].push = 0.5 * substep.h * (second.force - turn * first.force);
    kicks[k].twist = 0.5 * substep.h * (second.torque - turn * first.torque);
  }
  return kicks;
}

// Adds a rigid motion to the kicks of a group for which PressedGroup::on_obstacle is false, so that
// the momenta of the group change as much as those of bodies without contacts.
void keep_momenta(const MagneticModel& model, const KickedSubstep& substep,
                  const PressedGroup& group, const RigidState& now, std::vector<OwnKick>& kicks) {
  const GroupMass whole = group_mass(model, group, now);
  const BodyImpulses& without = substep.answer.without;
  Vec3 push = Vec3::Zero(), twist = Vec3::Zero();
  for (std::size_t k = 0; k < kicks.size(); ++k) {
    const Index b = group.bodies[k];
    const Wrench &first = substep.first[b], &second = substep.second[b];
    const Vec3 arm = now.positions.row(b).transpose() - whole.centre,
               before = substep.start.positions.row(b).transpose() - whole.centre;
    push += 0.5 * substep.h * (second.force - first.force) - kicks[k].push;
    twist +=
        before.cross(Vec3(without.linear.row(b).transpose())) - arm.cross(kicks[k].linear) +
        without.angular.row(b).transpose() - kicks[k].angular +
        0.5 * substep.h *
            (arm.cross(second.force) - before.cross(first.force) + second.torque - first.torque) -
        arm.cross(kicks[k].push) - kicks[k].twist;
  }
  const Vec3 velocity = push / whole.mass, spin = whole.inertia.ldlt().solve(twist);
  for (std::size_t k = 0; k < kicks.size(); ++k) {
    const Index b = group.bodies[k];
    const MassProperties& own = model.bodies[b].mass;
    const Vec3 arm = now.positions.row(b).transpose() - whole.centre;
    kicks[k].push += own.mass * (velocity + spin.cross(arm));
    kicks[k].twist += world_inertia(own, now.orientations.row(b).transpose()) * spin;
  }
}

// Returns whether a magnet or coil is on an obstacle or on a body in a bearing.
bool held_sources(const MagneticModel& model) {
  const auto held = [&](const auto& carried) {
    return carried.carrier >= model.n_bodies() || model.bodies[carried.carrier].bearing;
  };
  return std::ranges::any_of(model.magnets, held) || std::ranges::any_of(model.coils, held);
}

}  // namespace

void share_kicks(const MagneticModel& model, const KickedSubstep& substep, MovingBodies& bodies) {
  if (held_sources(model)) return;
  for (const PressedGroup& group : substep.answer.groups) {
    std::vector<OwnKick> kicks = own_kicks(model, substep, group);
    if (!group.on_obstacle) keep_momenta(model, substep, group, bodies.state, kicks);
    for (std::size_t k = 0; k < kicks.size(); ++k) {
      const Index b = group.bodies[k];
      bodies.state.velocities.row(b) =
          (kicks[k].linear + kicks[k].push).transpose() / model.bodies[b].mass.mass;
      bodies.momenta.row(b) = (kicks[k].angular + kicks[k].twist).transpose();
    }
  }
}

}  // namespace loomstone
