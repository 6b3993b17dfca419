// Collision algorithm for Bullet: spheres against spheres and against meshes and facets (facets.h)
// of obstacles.
#pragma once

#include "core/rigid/bullet.h"

namespace loomstone {

// Replaces Bullet's algorithms, which create contacts between spheres only once these overlap,
// create several contacts for one pair of spheres, and let spheres get caught at internal edges of
// a flat surface.
// This algorithm also creates the contacts that the sphere will reach on its path in this step.
// Unless the bodies bounce, the sphere then moves until it touches the other surface, without
// overlapping it first. A sphere that is struck during the step leaves this path and may overlap
// for one step.
class SphereAlgorithms {
 public:
  // Returns the number of bytes that a dispatcher's configuration must reserve per algorithm.
  static int size();
  // Registers the algorithm with the dispatcher. This object must outlive the dispatcher.
  void enter(btCollisionDispatcher& dispatcher);

 private:
  struct Create : btCollisionAlgorithmCreateFunc {
    btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                   const btCollisionObjectWrapper* first,
                                                   const btCollisionObjectWrapper* second) override;
  };
  Create create_;
};

}  // namespace loomstone
