// Contacts of convex polyhedra with triangles of obstacles, as an algorithm that Bullet calls.
#pragma once

#include <array>
#include <vector>

#include "core/rigid/bullet.h"

namespace loomstone {

// What a triangle of an obstacle that deforms knows of the others: shapes of single triangles point
// to it (getUserPointer).
struct FacetSurroundings {
  const Points* vertices;  // of all that deform, where they are now
  std::array<Index, 3> corners;
  std::vector<std::array<Index, 3>> others;  // those that share a corner
};

// In place of Bullet's own, which searches for how deep a hull is in a triangle and, where the
// triangle is much the larger, at times answers with a depth of the hull's size along any
// direction, and which holds hulls up at edges within a plane. A pair has four contact points in
// each of up to four planes. Hulls without a polyhedron are left to Bullet.
class HullMeetings {
 public:
  // What a dispatcher's configuration must leave room for.
  static int size();
  // Must outlive the dispatcher.
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
