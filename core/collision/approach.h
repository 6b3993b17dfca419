// Pairs of features that may touch within a step whose end is not known, for collisions at events
// within the step. They are those of the first stage of [Thomaszewski2010], 4.3.
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
  std::int64_t candidates = 0;         // pairs of the broad phase, those culled included
};

// Where pairs come from.
struct PairSource {
  const CollisionModel& model;
  const std::vector<SurfacePair>& pairs;
  BroadPhase& broad_phase;
};

// Allowance for velocities that change within a step. Our choice: features may approach at 1.5
// times their relative velocity and 0.3 m/s in addition. Few pairs come close sooner; they are left
// to certification.
inline constexpr double faster_approach = 1.5, added_approach = 0.3;

// Features that move at constant velocity.
struct ExpectedMotion {
  const Points& x0;  // (n x 3) [m]
  const Points& v0;  // (n x 3) [m/s]
  double step;       // [s]
};

// Finds the pairs that may come closer than their thickness, allowing for velocities that change
// within the step. Culls pairs whose four points stay off a common plane by more than the
// thickness. Neighbour lists would not do: they may lack pairs that are far apart, depending on
// when they were made.
Approach find_approach(const Team& team, const PairSource& source, const ExpectedMotion& motion,
                       const Tangle& tangle);

}  // namespace loomstone
