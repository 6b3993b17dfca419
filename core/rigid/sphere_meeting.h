// Contacts of spheres with one another and with obstacles' meshes, as an algorithm that Bullet calls.
#pragma once

#include "core/rigid/bullet.h"

namespace loomstone {

// In place of Bullet's own, which makes contacts of two spheres only once they overlap, several for each pair, and holds spheres
// up at edges within a plane. Contacts reach up to where the speeds lead in this step, unless bodies bounce: one that lies
// ahead lets bodies come just as near as touching, so that they need not overlap first.
class SphereMeetings {
 public:
  // What a dispatcher's configuration must leave room for.
  static int size();
  // Must outlive the dispatcher.
  void enter(btCollisionDispatcher& dispatcher);

 private:
  struct Create : btCollisionAlgorithmCreateFunc {
    btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info, const btCollisionObjectWrapper* first,
                                                   const btCollisionObjectWrapper* second) override;
  };
  Create create_;
};

}  // namespace loomstone
