// Bodies and obstacles as carriers of magnets and coils: where they are, how obstacles move, and
// what acts on them. Bodies are numbered first, then obstacles.
#pragma once

#include <cstdint>
#include <vector>

#include "core/magnetics/forces/interaction.h"
#include "core/rigid/rigid_body.h"

namespace loomstone {

// A wrench about the centre of each carrier, or one per ampere [N/A, N m/A].
using CarrierWrenches = std::vector<Wrench>;

// to += factor * what, carrier by carrier.
void add_times(CarrierWrenches& to, double factor, const CarrierWrenches& what);

// Where carriers are; a view.
struct CarrierPlaces {
  const RigidState& bodies;
  const std::vector<RigidPose>& obstacles;

  // Pose of a thing that a carrier holds at `local`: about a body's centre of mass, or an
  // obstacle's origin.
  RigidPose pose(Index carrier, const RigidPose& local) const;
  // About which wrenches on the carriers count (carriers x 3) [m].
  Points centres() const;
};

// Velocity and angular velocity of an obstacle within a step [m/s, rad/s].
struct Twist {
  Vec3 velocity = Vec3::Zero(), spin = Vec3::Zero();
  bool rests() const { return velocity.isZero(0.0) && spin.isZero(0.0); }
};

// Twists of obstacles that go from one pose to the other in `step` [s].
std::vector<Twist> obstacle_twists(const std::vector<RigidPose>& from,
                                   const std::vector<RigidPose>& to, double step);

}  // namespace loomstone
