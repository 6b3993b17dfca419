// Finds the pairs of features that may touch during an asynchronous step, before the motion of the
// step is known. Contacts at events within the step are then evaluated for these pairs only. This
// is the first stage of [Thomaszewski2010], 4.3.
#pragma once

#include <vector>

#include "core/collision/broad_phase/broad_phase.h"
#include "core/collision/tangle/tangle.h"

namespace loomstone {

struct ApproachingPair {
  ContactKind kind;
  PairKey key;
  Index pair;  // index of the surface pair
};

struct Approach {
  std::vector<ApproachingPair> pairs;  // sorted by (kind, a, b)
  std::int64_t candidates = 0;         // number of pairs tested, including culled ones
};

struct PairSource {
  const CollisionModel& model;
  const std::vector<SurfacePair>& pairs;
  BroadPhase& broad_phase;
  const Communicator& ranks;  // ranks that divide the tasks of the broad phase
};

// Allowance for velocities that change within a step. Our choice: features are assumed to approach
// at no more than 1.5 times their relative velocity plus 0.3 m/s. The few pairs that approach
// faster are left to certification.
inline constexpr double faster_approach = 1.5, added_approach = 0.3;

// Expected motion of all vertices in a step, at constant velocity.
struct ExpectedMotion {
  const Points& x0;  // (n x 3) [m]
  const Points& v0;  // (n x 3) [m/s]
  double step;       // [s]
};

// Collective. Finds the pairs that may come closer than their thickness, allowing for velocities
// that change within the step. Culls pairs whose distance stays above the thickness along the
// normal of the face, or along the common normal of the two edges. Does not use neighbour lists:
// they may lack pairs that are far apart, depending on when they were made.
Approach find_approach(const Team& team, const PairSource& source, const ExpectedMotion& motion,
                       const Tangle& tangle);

}  // namespace loomstone
