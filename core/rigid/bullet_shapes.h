// Bullet's collision shapes of bodies and obstacles.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/mesh/triangle_mesh.h"
#include "core/rigid/bullet.h"
#include "core/rigid/contacts/convex_polyhedron.h"
#include "core/rigid/rigid_body.h"

namespace loomstone {

// The shapes of a body. If a shape is a box, or a hull with at most most_vertices_on_triangles
// vertices (shape_geometry.h), its user pointer (getUserPointer) refers to its ConvexPolyhedron.
struct Shapes {
  std::vector<std::unique_ptr<btCollisionShape>> all;  // last: shape of the whole body
  std::vector<std::unique_ptr<ConvexPolyhedron>> polyhedra;

  btCollisionShape& whole() const { return *all.back(); }
};

// Creates the shapes of a body. The columns of `principal` are Bullet's body axes in mesh axes.
// Throws InvalidInput if the mesh of a sphere is not round, the mesh of a box is not a box, a hull
// is flat or parts are missing.
Shapes make_shapes(const RigidBody& body, const MassProperties& mass, const Mat3& principal,
                   const std::string& where);

// A mesh in Bullet's format. Owns the arrays that Bullet refers to.
struct ObstacleMesh {
  Points vertices;
  Triangles triangles;
  btTriangleIndexVertexArray arrays;
  std::unique_ptr<btBvhTriangleMeshShape> shape;

  explicit ObstacleMesh(const TriangleMesh& mesh)
      : vertices(mesh.vertices()), triangles(mesh.triangles()) {
    btIndexedMesh indexed;
    indexed.m_numTriangles = static_cast<int>(triangles.rows());
    indexed.m_triangleIndexBase = reinterpret_cast<const unsigned char*>(triangles.data());
    indexed.m_triangleIndexStride = 3 * sizeof(Index);
    indexed.m_numVertices = static_cast<int>(vertices.rows());
    indexed.m_vertexBase = reinterpret_cast<const unsigned char*>(vertices.data());
    indexed.m_vertexStride = 3 * sizeof(double);
    indexed.m_vertexType = PHY_DOUBLE;
    arrays.addIndexedMesh(indexed, PHY_INTEGER);
    shape = std::make_unique<btBvhTriangleMeshShape>(&arrays, true);
  }
};

}  // namespace loomstone
