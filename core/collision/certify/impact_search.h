// Finds the impacts of a motion x0 -> x1: pairs of features for which continuous collision
// detection cannot prove that they stay farther apart than gap_floor() (narrow_phase/continuous.h).
// ImpactSearch::find() states which pairs are excluded. Candidates come from the neighbour lists
// and, for surface pairs without lists, from the broad phase. If share() has set a SharedSearch,
// all candidates come from this search instead.
#pragma once

#include <vector>

#include "core/base/bytes.h"
#include "core/collision/broad_phase/neighbour_lists.h"
#include "core/collision/broad_phase/shared_search.h"
#include "core/collision/narrow_phase/continuous.h"
#include "core/collision/response/response_inputs.h"

namespace loomstone {

struct StepImpact {
  ContactKind kind;
  PairKey key;
  Index pair;  // index of the surface pair
  std::array<Index, 4> vertices;
  Impact impact;
};

class ImpactSearch {
 public:
  ImpactSearch(const CollisionModel& model, BroadPhase& broad_phase, NeighbourLists& lists);

  // Collective. Each rank tests a share of the pairs, and all ranks receive all impacts. Returns
  // the impacts sorted by (kind, key). Excludes pairs that touch at x0 (Impact::touching), pairs
  // without a movable vertex, and pairs that the tangle ignores. If `changed` (n) is not null,
  // tests only pairs with a vertex whose entry in `changed` is 1. If the search uses the lists,
  // they are updated to x0.
  std::vector<StepImpact> find(const Team& team, const MotionInputs& inputs, const Points& x1,
                               const std::vector<std::uint8_t>* changed);

  // If `shared` is not null, searches traverse its trees and do not use the lists.
  void share(SharedSearch* shared) { shared_ = shared; }

  const CollisionModel& model() const { return model_; }
  std::size_t bytes() const { return bytes_of(travel_); }

 private:
  struct PairTest;
  std::vector<StepImpact> find_own(const Team& team, const PairTest& test);
  std::vector<StepImpact> find_listed(const Team& team, const PairTest& test);
  void find_in_list(NeighbourList& list, const PairTest& test,
                    std::vector<StepImpact>& impacts) const;
  std::vector<StepImpact> find_shared(const Team& team, const PairTest& test) const;
  void find_unlisted(const Team& team, const PairTest& test, std::vector<StepImpact>& impacts);

  const CollisionModel& model_;
  BroadPhase& broad_phase_;
  NeighbourLists& lists_;
  SharedSearch* shared_ = nullptr;
  GatherRoom room_;
  // (n) Length of the displacement of each vertex in the lists of this rank [m].
  std::vector<double> travel_;
};

}  // namespace loomstone
