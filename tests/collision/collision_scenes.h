// Small scenes for the collision tests. Each mesh of a scene becomes a collision surface.
#pragma once

#include <cmath>
#include <random>
#include <vector>

#include "core/collision/model/collision_model.h"
#include "core/mesh/adjacency.h"
#include "core/mesh/generators.h"

namespace loomstone {

struct Part {
  TriangleMesh mesh;
  CollisionSurface::Kind kind = CollisionSurface::Kind::Cloth;
  double thickness = 2e-3;  // [m]
  double friction = 0.3;
};

struct TestScene {
  CollisionModel model;
  Points x;             // start positions [m]
  Vector inverse_mass;  // [1/kg]: 1000 for cloth (1 g per vertex), 0 for other surfaces
};

inline TestScene make_scene(const std::vector<Part>& parts) {
  TestScene scene;
  CollisionModel& model = scene.model;
  Index n = 0, m = 0, n_cloth = 0, n_bodies = 0;
  for (const Part& part : parts) {
    n += part.mesh.n_vertices();
    m += part.mesh.n_triangles();
    if (part.kind == CollisionSurface::Kind::Cloth) n_cloth += part.mesh.n_vertices();
  }
  model.n_vertices = n;
  model.triangles.resize(m, 3);
  scene.x.resize(n, 3);
  scene.inverse_mass = Vector::Zero(n);
  Index vertex = 0, triangle = 0;
  for (const Part& part : parts) {
    CollisionSurface surface;
    surface.kind = part.kind;
    surface.first_vertex = vertex;
    surface.n_vertices = part.mesh.n_vertices();
    surface.first_triangle = triangle;
    surface.n_triangles = part.mesh.n_triangles();
    surface.thickness = part.thickness;
    surface.friction = part.friction;
    const bool cloth = part.kind == CollisionSurface::Kind::Cloth,
               body = part.kind == CollisionSurface::Kind::Body;
    surface.body = body ? n_bodies : -1;
    for (Index i = 0; i < surface.n_vertices; ++i) {
      scene.x.row(vertex + i) = part.mesh.vertices().row(i);
      model.rows.row.push_back(cloth ? vertex + i : body ? n_cloth + 2 * n_bodies : -1);
      model.rows.is_body.push_back(body);
      if (cloth) scene.inverse_mass[vertex + i] = 1e3;
    }
    for (Index t = 0; t < surface.n_triangles; ++t)
      for (int k = 0; k < 3; ++k)
        model.triangles(triangle + t, k) = part.mesh.triangles()(t, k) + vertex;
    if (body) ++n_bodies;
    vertex += surface.n_vertices;
    triangle += surface.n_triangles;
    model.surfaces.push_back(surface);
  }
  model.edges = edge_table(n, model.triangles).edges;
  return scene;
}

// Returns x with each coordinate displaced at random by up to `amount`.
inline Points shaken(const Points& x, double amount, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-amount, amount);
  Points moved = x;
  for (Index i = 0; i < x.rows(); ++i)
    for (int k = 0; k < 3; ++k) moved(i, k) += uniform(random);
  return moved;
}

inline Vec3 random_vector(std::mt19937& random, double amount) {
  std::uniform_real_distribution<double> uniform(-amount, amount);
  const double x = uniform(random), y = uniform(random), z = uniform(random);
  return {x, y, z};
}

}  // namespace loomstone
