// Rate at which relative motion changes the forces and induced voltages between magnets. Sub-steps
// must resolve this rate, even if the motion is so fast that forces hardly influence the motion.
#pragma once

#include <vector>

#include "core/magnetics/forces/stiffness.h"

namespace loomstone {

// Motion of a carrier of magnets.
struct CarrierMotion {
  Vec3 centre = Vec3::Zero();                         // point that has `velocity`, world axes [m]
  Vec3 velocity = Vec3::Zero(), spin = Vec3::Zero();  // [m/s], [rad/s]
};

// Magnets at one instant. `carriers` contains the index of each magnet's carrier.
struct MovingMagnets {
  const std::vector<CoarseMagnet>& magnets;
  const std::vector<RigidPose>& poses;
  const std::vector<Index>& carriers;
  const std::vector<CarrierMotion>& motions;  // of the carriers
};

// Returns the largest rate of all pairs of magnets on different carriers [1/s]. The rate of a pair
// is the relative velocity of two dipoles, one of each magnet, divided by their distance, plus the
// larger of the angular velocities of the two magnets. The two dipoles with the largest ratio
// count. If their distance is less than the mean size of the two parts that they represent, this
// mean size replaces the distance. The angular velocity of a soft sphere counts as zero. First
// computes a cheap upper bound of the result, and returns this bound if it is at most `negligible`.
double relative_motion_rate(const Team& team, const MovingMagnets& moving, double negligible);

}  // namespace loomstone
