// Collision algorithm for Bullet: pairs of convex shapes of bodies, except two spheres, and hulls
// without a ConvexPolyhedron against triangles of obstacles.
#pragma once

#include <array>

#include "core/rigid/bullet.h"

namespace loomstone {

// Bullet's algorithms create contacts only where shapes overlap or nearly touch, so fast bodies
// would sink into each other or pass through each other. If two shapes have no contact and move
// relative to each other by more than Bullet's contact breaking threshold, this algorithm divides
// the step into equal parts and tests the shapes at the end of each part. At the earliest of these
// times at which the shapes overlap, it takes those contact points of Bullet's algorithm that
// overlap, and moves them back with the shapes to the start of the step. Points whose gap is not
// positive there are left out. In a part, the shapes move relative to each other by at most the
// smaller of their inner radii (step_motion.h), unless this would need more than 32 parts. Surfaces
// have no inner radius.
class PairAlgorithms {
 public:
  // Returns the number of bytes that a dispatcher's configuration must reserve per algorithm.
  static int size();
  // Registers the algorithms with the dispatcher. This object must outlive the dispatcher.
  void enter(btCollisionDispatcher& dispatcher, btCollisionConfiguration& configuration);

 private:
  struct Create : btCollisionAlgorithmCreateFunc {
    btCollisionAlgorithmCreateFunc* bullets = nullptr;  // creates Bullet's algorithm
    btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                   const btCollisionObjectWrapper* first,
                                                   const btCollisionObjectWrapper* second) override;
  };
  std::array<Create, 8> create_;  // {sphere, hull, box} with each other, but not two spheres
};

// Returns the algorithm that `bullets` creates for a pair of shapes, extended by contacts ahead of
// the motion as in PairAlgorithms.
btCollisionAlgorithm* with_contacts_ahead(btCollisionAlgorithmConstructionInfo& info,
                                          btCollisionAlgorithmCreateFunc& bullets,
                                          const btCollisionObjectWrapper* first,
                                          const btCollisionObjectWrapper* second);

}  // namespace loomstone
