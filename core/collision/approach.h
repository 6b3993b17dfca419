// Finds the pairs of features that may touch during an asynchronous step, before the motion of the
// step is known. Contacts at events within the step are then evaluated for these pairs only. This
// is the first stage of [Thomaszewski2010], 4.3.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "core/collision/broad_phase/neighbour_lists.h"
#include "core/collision/narrow_phase/distance.h"
#include "core/collision/tangle/tangle.h"

namespace loomstone {

struct ApproachingPair {
  ContactKind kind;
  PairKey key;
  Index pair;            // index of the surface pair
  bool contact;          // the pair is a contact at the start of the step, see ApproachSearch
  double wake = 0.0;     // earliest time in the step when it may be closer than its thickness [s]
  std::int8_t side = 0;  // side_of() at the start if the closest points are interior; 0: unknown
};

struct Approach {
  std::vector<ApproachingPair> pairs;  // sorted by (kind, a, b)
  std::int64_t candidates = 0;         // number of pairs within reach, also if culled or ignored
};

// Allowance for velocities that change within a step. Our choice: features are assumed to approach
// at no more than 1.5 times their relative velocity plus 0.3 m/s. The few pairs that approach
// faster are left to certification.
inline constexpr double faster_approach = 1.5, added_approach = 0.3;

// Returns the sign of the volume that the four points span. The sign tells on which side of the
// face the vertex lies, or on which side of the second edge the first edge passes.
std::int8_t side_of(ContactKind kind, const FourPoints& points);

// Returns the largest speed at which a corner of feature a approaches a corner of feature b along
// the contact normal [m/s]. At constant velocities, the distance along the normal decreases at most
// at this speed. `speeds` are those of the four vertices along the normal, which points from b to a
// [m/s].
inline double largest_approach(ContactKind kind, const std::array<double, 4>& speeds) {
  if (kind == ContactKind::VertexFace)
    return std::max({speeds[1], speeds[2], speeds[3]}) - speeds[0];
  return std::max(speeds[2], speeds[3]) - std::min(speeds[0], speeds[1]);
}
// Returns the shortest time in which a pair that approaches at this speed may close this gap [s].
inline double time_to_close(double gap, double approach) {  // [m], [m/s]
  return gap / (faster_approach * std::max(0.0, approach) + added_approach);
}

// Expected motion of all vertices in a step, at constant velocity.
struct ExpectedMotion {
  const Points& x0;  // (n x 3) [m]
  const Points& v0;  // (n x 3) [m/s]
  double step;       // [s]
};

// Finds the pairs that may come closer than their thickness, allowing for velocities that change
// within the step. Candidates are pairs whose distance at the start is at most their thickness plus
// their largest relative displacement, and whose 18-DOPs overlap. The 18-DOPs enclose the motion at
// the assumed speed. A candidate is culled if its distance stays above the thickness along one of
// these directions: from closest point to closest point at the start, the normal of the face, or
// the common normal of the two edges. A pair is a contact if it is closer than its thickness at the
// start. For edges, the closest points must also lie inside both edges, and neither surface may be
// smooth.
class ApproachSearch {
 public:
  // Certification uses the same lists. Pairs that only certification needs do not affect results.
  ApproachSearch(const CollisionModel& model, const std::vector<SurfacePair>& pairs,
                 BroadPhase& broad_phase, NeighbourLists& lists);

  // Collective. Returns the pairs found by all ranks. Each rank tests the pairs in its lists, which
  // are updated to motion.x0 if necessary. Surface pairs without lists, or all if `in_lists` is
  // false, are searched in the broad phase.
  Approach find(const Team& team, const ExpectedMotion& motion, const Tangle& tangle,
                bool in_lists);

 private:
  struct PairTest;
  struct Note;
  void find_boxes(const Team& team, const ExpectedMotion& motion);
  void find_in_list(NeighbourList& list, const PairTest& test, Approach& found) const;
  Approach find_listed(const Team& team, const PairTest& test);
  Approach find_unlisted(const Team& team, const PairTest& test, const std::vector<Index>& which);

  const CollisionModel& model_;
  const std::vector<SurfacePair>& pairs_;
  BroadPhase& broad_phase_;
  NeighbourLists& lists_;
  GatherRoom room_;
  std::vector<double> thickness_;    // largest thickness among the pairs of each surface [m]
  std::vector<PackedSlabs> motion_;  // scratch: boxes of the motion of the vertices
  Points x1_;                        // scratch: positions at the end, at the assumed speed [m]
};

}  // namespace loomstone
