// Lists of feature pairs that are near, kept over several steps. A list made with reach xi + slack stays complete while the
// distances of its two surfaces have changed by no more than the slack; how far that may be is bounded by each surface's
// displacement about its mean. Lists are a superset either way: how long they live changes no result.
#pragma once

#include <vector>

#include "core/collision/broad_phase.h"

namespace loomstone {

// Displacements of a surface's vertices lie in a ball: |displacement - centre| <= radius.
struct SurfaceMotion {
  Vec3 centre = Vec3::Zero();  // [m]
  double radius = 0.0;         // [m]
};
std::vector<SurfaceMotion> surface_motions(const CollisionModel& model, const Points& x0, const Points& x1);

struct NearList {
  FeaturePairs pairs;
  std::vector<double> vertex_face_distance, edge_edge_distance;  // at the x of the last update() [m]
};

class NearLists {
 public:
  NearLists(const CollisionModel& model, const std::vector<SurfacePair>& pairs, BroadPhase& broad_phase);

  // Makes every list hold all pairs closer than the thickness at x; distances are then the caller's to fill.
  void update(const Team& team, const Points& x);
  bool updated_at(const Points& x) const;

  // Does list i hold every pair that may come closer than the thickness while x0 -> x1, x0 being that of update()?
  bool covers(Index i, const std::vector<SurfaceMotion>& motions) const;

  NearList& list(Index i) { return lists_[i]; }

 private:
  double change_bound(Index i, const std::vector<SurfaceMotion>& motions) const;

  const CollisionModel& model_;
  const std::vector<SurfacePair>& pairs_;
  BroadPhase& broad_phase_;
  Points previous_;                    // x of the last update
  std::vector<NearList> lists_;
  std::vector<double> slack_, used_;   // [m]
};

}  // namespace loomstone
