// Obstacles that deform. Each of their triangles is a body of its own, so that bodies resting on it
// meet the velocity of that very place.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "core/rigid/bullet.h"
#include "core/rigid/rigid_body.h"

namespace loomstone {

// A triangle of such an obstacle and its neighbours; its collision shape points to it
// (getUserPointer).
struct FacetSurroundings {
  const Points* vertices;  // current positions of all obstacles that deform
  std::array<Index, 3> corners;
  std::vector<std::array<Index, 3>> others;  // triangles with a common corner
};

struct Facet {
  FacetSurroundings around;
  double friction;
  std::unique_ptr<btTriangleShape> shape = std::make_unique<btTriangleShape>();

  // (3 x 3) corners among the positions x.
  Mat3 at(const Points& x) const;
  // Moves the body to its corners. The body's axes rotate with the triangle, so contact points
  // carried over from the last step keep their place on it.
  void put(btRigidBody& body, const Points& x) const;
};

// Appends the facets of an obstacle whose vertices are those from `first` on in `vertices`.
void add_facets(const RigidObstacle& obstacle, Index first, const Points& vertices,
                std::vector<Facet>& facets);

}  // namespace loomstone
