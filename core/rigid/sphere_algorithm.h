// Bullet's collision algorithm for spheres, among themselves and with meshes of obstacles.
#pragma once

#include "core/rigid/bullet.h"

namespace loomstone {

// Replaces Bullet's own algorithms, which create contacts of two spheres only after they overlap,
// several per pair, and obstruct spheres at edges inside a plane. Unless bodies bounce, there are
// also contacts ahead: those on the path of the sphere in this step, which let it move up to
// touching without overlapping first. A sphere that is struck within the step leaves that path and
// may overlap for one step.
class SphereAlgorithms {
 public:
  // Bytes that a dispatcher's configuration must reserve per algorithm.
  static int size();
  // Registers the algorithms; they must outlive the dispatcher.
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
