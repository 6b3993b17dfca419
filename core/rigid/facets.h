// Facets: the triangles of deforming obstacles. Each facet is a separate Bullet body, so that a
// body that rests on it is carried along at the local velocity of the surface.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "core/rigid/bullet.h"
#include "core/rigid/rigid_body.h"

namespace loomstone {

// A triangle of a deforming obstacle, with its neighbours. The user pointer (getUserPointer) of its
// collision shape refers to this struct.
struct FacetSurroundings {
  const Points* vertices;  // current vertices of all deforming obstacles
  std::array<Index, 3> corners;
  std::vector<std::array<Index, 3>> others;  // triangles that share a corner with this one
};

struct Facet {
  FacetSurroundings around;
  double friction;
  std::unique_ptr<btTriangleShape> shape = std::make_unique<btTriangleShape>();

  // Returns the positions of the corners (3 x 3, one corner per row), given the vertex positions x.
  Mat3 at(const Points& x) const;
  // Moves the triangle's Bullet body to the corners given by the vertex positions x. The axes of
  // the body rotate with the triangle, so contact points of the previous step keep their position
  // on the triangle.
  void put(btRigidBody& body, const Points& x) const;
};

// Appends the facets of an obstacle. The facets keep a pointer to `vertices`, where the vertices of
// the obstacle begin at row `first`.
void add_facets(const RigidObstacle& obstacle, Index first, const Points& vertices,
                std::vector<Facet>& facets);

}  // namespace loomstone
