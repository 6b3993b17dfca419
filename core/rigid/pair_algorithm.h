// Collision algorithm for Bullet: pairs of convex bodies, at least one of which is not a sphere.
#pragma once

#include <array>

#include "core/rigid/bullet.h"

namespace loomstone {

// Bullet's algorithms create contacts only where bodies overlap or nearly touch, so fast bodies
// would sink into each other or pass through each other. If two fast bodies have no contact, but
// overlap during the step or at its end, this algorithm creates the contacts of the first such
// overlap, with the gaps at the start of the step. Overlaps are searched for at the ends of equal
// parts of the step. In a part, the bodies move relative to each other by at most the smaller of
// their inner radii (step_motion.h), unless this would need more than 32 parts.
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
