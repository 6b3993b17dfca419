// Bodies and obstacles as carriers of magnets and coils: their poses, the motion of obstacles, and
// the wrenches on the carriers. Carriers are numbered with bodies first, then obstacles.
#pragma once

#include <cstdint>
#include <vector>

#include "core/magnetics/forces/interaction.h"
#include "core/rigid/rigid_body.h"

namespace loomstone {

// The wrench on each carrier about its reference point (CarrierPlaces::centres()) [N, N m], or this
// wrench per ampere [N/A, N m/A] or per square ampere [N/A^2, N m/A^2].
using CarrierWrenches = std::vector<Wrench>;

// Adds `factor` times each wrench of `what` to the wrench of the same carrier in `to`.
void add_times(CarrierWrenches& to, double factor, const CarrierWrenches& what);

// Non-owning view of the poses of all carriers.
struct CarrierPlaces {
  const RigidState& bodies;
  const std::vector<RigidPose>& obstacles;

  // Returns the world pose of a magnet or coil that is mounted on a carrier at the pose `local`,
  // which is relative to a body's centre of mass or an obstacle's origin.
  RigidPose pose(Index carrier, const RigidPose& local) const;
  // Returns the reference points of the wrenches on the carriers (carriers x 3) [m]: the centres of
  // mass of bodies and the origins of obstacles.
  Points centres() const;
};

// Velocity of the reference point of a carrier (CarrierPlaces::centres()), and angular velocity of
// the carrier [m/s, rad/s]. Those of an obstacle are constant within a step.
struct Twist {
  Vec3 velocity = Vec3::Zero(), spin = Vec3::Zero();
  bool rests() const { return velocity.isZero(0.0) && spin.isZero(0.0); }
};

// Returns the twists of obstacles that move from the poses `from` to the poses `to` in `step` [s].
std::vector<Twist> obstacle_twists(const std::vector<RigidPose>& from,
                                   const std::vector<RigidPose>& to, double step);

}  // namespace loomstone
