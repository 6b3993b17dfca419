// Collision algorithm for Bullet: convex polyhedra against triangles of obstacles.
#pragma once

#include <array>
#include <vector>

#include "core/rigid/bullet.h"

namespace loomstone {

// Replaces Bullet's algorithm, which searches for the penetration depth. If the triangle is much
// larger than the hull, that search sometimes returns a depth as large as the hull, in an arbitrary
// direction. With Bullet's algorithm, hulls also get caught at internal edges of a flat surface.
// This algorithm creates up to four contact points in each contact plane. A hull and a mesh have up
// to four contact planes; a hull and a facet (facets.h) have at most one. A fast hull gets contacts
// before it touches the surface. Hulls without a ConvexPolyhedron (bullet_shapes.h) keep Bullet's
// algorithm, extended by contacts ahead of the motion (pair_algorithm.h).
class HullAlgorithms {
 public:
  // Returns the number of bytes that a dispatcher's configuration must reserve per algorithm.
  static int size();
  // Registers the algorithms with the dispatcher. This object must outlive the dispatcher.
  void enter(btCollisionDispatcher& dispatcher, btCollisionConfiguration& configuration);

 private:
  struct Create : btCollisionAlgorithmCreateFunc {
    // Creates Bullet's algorithm, for hulls without a ConvexPolyhedron.
    btCollisionAlgorithmCreateFunc* others = nullptr;
    btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                   const btCollisionObjectWrapper* first,
                                                   const btCollisionObjectWrapper* second) override;
  };
  std::array<Create, 8> create_;  // {hull, box} with {mesh, triangle}, in both orders
};

}  // namespace loomstone
