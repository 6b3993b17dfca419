// Bullet's collision algorithm for convex polyhedra and triangles of obstacles.
#pragma once

#include <array>
#include <vector>

#include "core/rigid/bullet.h"

namespace loomstone {

// Replaces Bullet's own algorithm, which searches for the penetration depth. If the triangle is
// much larger than the hull, that search sometimes returns the size of the hull along an arbitrary
// direction, and it obstructs hulls at edges inside a plane. Here a pair has four contact points in
// each of up to four planes. Hulls without a polyhedron use Bullet's algorithm.
class HullAlgorithms {
 public:
  // Bytes that a dispatcher's configuration must reserve per algorithm.
  static int size();
  // Registers the algorithms; they must outlive the dispatcher.
  void enter(btCollisionDispatcher& dispatcher, btCollisionConfiguration& configuration);

 private:
  struct Create : btCollisionAlgorithmCreateFunc {
    btCollisionAlgorithmCreateFunc* others = nullptr;  // Bullet's, for hulls without a polyhedron
    btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                   const btCollisionObjectWrapper* first,
                                                   const btCollisionObjectWrapper* second) override;
  };
  std::array<Create, 8> create_;  // hull and box, mesh and triangle, either first
};

}  // namespace loomstone
