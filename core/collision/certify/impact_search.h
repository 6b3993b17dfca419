// All impacts of a step: pairs of features that come closer than the floor under gaps while x0 ->
// x1.
#pragma once

#include <vector>

#include "core/collision/broad_phase/neighbour_lists.h"
#include "core/collision/narrow_phase/continuous.h"
#include "core/collision/response/response_inputs.h"

namespace loomstone {

struct StepImpact {
  ContactKind kind;
  PairKey key;
  Index pair;  // of surfaces
  std::array<Index, 4> vertices;
  Impact impact;
};

class ImpactSearch {
 public:
  ImpactSearch(const CollisionModel& model, BroadPhase& broad_phase, NearLists& lists);

  // Sorted by (kind, a, b). Left out are pairs that touch at x0 already, pairs of which no vertex
  // has an inverse mass, and features of triangles that intersect at x0 (those of the tangle). With
  // `changed` (n) only pairs with a changed vertex are looked at. The lists are brought up to x0
  // where they are not.
  std::vector<StepImpact> find(const Team& team, const MotionInputs& inputs, const Points& x1,
                               const std::vector<std::uint8_t>* changed);

  const CollisionModel& model() const { return model_; }

 private:
  struct PairTest;
  std::vector<StepImpact> find_listed(const Team& team, const PairTest& test) const;
  void find_in_list(const NearList& list, const PairTest& test,
                    std::vector<StepImpact>& impacts) const;
  void find_unlisted(const Team& team, const PairTest& test, std::vector<StepImpact>& impacts);

  const CollisionModel& model_;
  BroadPhase& broad_phase_;
  NearLists& lists_;
  std::vector<double> travel_;  // (n) length of each displacement [m]
};

}  // namespace loomstone
