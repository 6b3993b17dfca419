// Collision algorithm for Bullet: pairs of convex bodies, of which at least one is no sphere.
#pragma once

#include <array>

#include "core/rigid/bullet.h"

namespace loomstone {

// Returns the pose of a shape after a step in which nothing touches its body.
btTransform pose_after(const btCollisionObjectWrapper& shape, btScalar step);
// Returns the motion of the second object in a step in which nothing touches the two objects, in
// the axes of the first.
btTransform relative_motion(const btCollisionObjectWrapper& first,
                            const btCollisionObjectWrapper& second, btScalar step);
// Returns an upper bound on the distance by which points of a shape move in a motion that is given
// in its axes [m].
double largest_motion(const btCollisionShape& shape, const btTransform& motion);

// Bullet's algorithms create contacts only where bodies overlap or nearly touch, so fast bodies
// would sink into each other. If two fast bodies have no contact, but overlap after the step, this
// algorithm creates the contacts of that overlap, with the gaps at the start of the step.
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

}  // namespace loomstone
