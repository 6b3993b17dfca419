// Finds the pairs of features that may come closer than their thickness during an asynchronous
// step, before the motion of the step is known. Contacts at events within the step are then
// evaluated for these pairs only. This is the first stage of [Thomaszewski2010], 4.3.
#pragma once

#include <array>
#include <vector>

#include "core/collision/broad_phase/neighbour_lists.h"
#include "core/collision/narrow_phase/distance.h"
#include "core/collision/tangle/tangle.h"

namespace loomstone {

struct ApproachingPair {
  ContactKind kind;
  PairKey key;
  Index pair;    // index of the surface pair
  bool contact;  // true: the pair is a contact at the start of the step, see ApproachSearch
  // Earliest time after the start of the step at which the pair may be closer than its thickness
  // and, if it consists of two edges, its closest points may lie inside both edges [s].
  double wake = 0.0;
  std::int8_t side = 0;  // side_of() at the start if ClosestPair::interior is true; 0: unknown
  // Unit vector at the start from the closest point of the second feature to that of the first, or
  // zero if these points coincide.
  Vec3 normal = Vec3::Zero();
};

struct Approach {
  std::vector<ApproachingPair> pairs;  // sorted by (kind, key)
  // Number of candidates (see ApproachSearch), including those that are culled or ignored.
  std::int64_t candidates = 0;
};

// Returns the sign (-1, 0 or 1) of the oriented volume that the four points span. The sign tells on
// which side of the face the vertex lies (1: the side to which the face's normal points), or on
// which side of the second edge the first edge passes.
std::int8_t side_of(ContactKind kind, const FourPoints& points);

// Expected motion of all vertices in a step, at constant velocity.
struct ExpectedMotion {
  const Points& x0;  // (n x 3) [m]
  const Points& v0;  // (n x 3) [m/s]
  double step;       // length of the step [s]
};

// Finds the pairs that may come closer than their thickness, allowing for velocities that change
// within the step (approach_bounds.h). Candidates are pairs whose distance at the start is at most
// their thickness plus largest_loss() at their relative speed, and whose 18-DOPs overlap. The
// 18-DOPs enclose the motion at faster_approach times the expected velocities, with a margin for
// the thickness and for the allowance at zero speed. A candidate is culled if its distance stays
// above the thickness along one of these directions: the line through the closest points at the
// start, the normal of the face, or the common normal of the two edges. Two edges whose closest
// points do not lie inside both edges are also culled if they cannot move by motion_to_cross()
// (narrow_phase/crossing.h) relative to each other within the step. A pair is a contact if it is
// closer than its thickness at the start. For edges, the closest points must also lie inside both
// edges, and neither surface may be smooth (CollisionSurface::smooth).
class ApproachSearch {
 public:
  // Certification uses the same `lists`. Pairs that are in the lists only because certification
  // needs them do not affect the results of find().
  ApproachSearch(const CollisionModel& model, const std::vector<SurfacePair>& pairs,
                 BroadPhase& broad_phase, NeighbourLists& lists);

  // Collective. Returns the pairs found by all ranks, except those that `tangle` ignores. If
  // `in_lists` is true, each rank tests the pairs in its lists, which are updated to motion.x0 if
  // necessary, and the broad phase searches surface pairs without lists. Otherwise, the broad phase
  // searches all surface pairs.
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
  // For each surface, the largest thickness of the surface pairs that contain it [m].
  std::vector<double> thickness_;
  std::vector<PackedSlabs> motion_;  // scratch: boxes of the motion of the vertices
  Points x1_;                        // scratch: positions after a step at faster_approach * v0 [m]
};

}  // namespace loomstone
