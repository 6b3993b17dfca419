// Contacts of spheres with one another and with obstacles' meshes, as an algorithm that Bullet
// calls.
#pragma once

#include "core/rigid/bullet.h"

namespace loomstone {

// In place of Bullet's own, which makes contacts of two spheres only once they overlap, several for
// each pair, and holds spheres up at edges within a plane. Unless bodies bounce there are contacts
// also with what lies on their way in this step, which let them come just as near as touching, so
// that they need not overlap first. What a sphere meets only because it is struck within the step
// is not on its way: it may sink in for a step.
class SphereMeetings {
 public:
  // What a dispatcher's configuration must leave room for.
  static int size();
  // Must outlive the dispatcher.
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
