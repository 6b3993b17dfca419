// Rate at which relative motion changes the forces between magnets and currents, and the voltages
// that they induce in one another. Sub-steps must resolve this rate, even if the motion is so fast
// that forces hardly influence the motion.
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
// is the sum of two terms. The first is the relative speed of two dipoles, one of each magnet,
// divided by their distance; the two dipoles with the largest ratio count. If their distance is
// less than the mean size of the two parts that they represent, this mean size replaces the
// distance. The second term is the larger of the angular speeds of the two magnets. In this term, a
// soft sphere counts as not rotating. If a cheap upper bound of the result is at most `negligible`,
// the function returns this bound instead.
double relative_motion_rate(const Team& team, const MovingMagnets& moving, double negligible);

}  // namespace loomstone
