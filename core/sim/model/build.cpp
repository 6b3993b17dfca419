#include <algorithm>
#include <sstream>

#include "core/base/message.h"
#include "core/collision/tangle/intersections.h"
#include "core/mesh/spatial_query.h"
#include "core/sim/model/build.h"
#include "core/sim/model/motion.h"
#include "core/sim/scene/numbered_names.h"

namespace loomstone {

namespace {

// Returns a string that identifies a collision triangle in messages: the name of its surface and
// its index in the user's mesh of this surface.
std::string place(const Model& model, Index triangle) {
  const CollisionSurface& surface =
      model.collision.surfaces[model.collision.surface_of_triangle(triangle)];
  Index local = triangle - surface.first_triangle;
  if (surface.kind == CollisionSurface::Kind::Cloth) {
    Index first = 0;  // number of triangles in preceding cloths
    for (const auto& other : model.collision.surfaces) {
      if (&other == &surface) break;
      first += other.n_triangles;
    }
    local = model.triangle_of[triangle] - first;
  }
  return formatted("{} triangle {}", surface.name, local);
}

// Returns the index of the cloth that contains a vertex. `user` is the index of the vertex over all
// cloths, in the user's order.
Index cloth_of_vertex(const Model& model, std::size_t user) {
  const std::vector<Index>& first = model.cloth.first_vertex;
  const auto next = std::upper_bound(first.begin(), first.end(), static_cast<Index>(user));
  return static_cast<Index>(next - first.begin()) - 1;
}

// Converts a vertex index over all cloths, in the user's order, to the index within its cloth.
Index vertex_in_cloth(const Model& model, std::size_t user) {
  return static_cast<Index>(user) - model.cloth.first_vertex[cloth_of_vertex(model, user)];
}

void check_intersections(const Model& model, const Points& vertices) {
  const auto pairs = cloth_intersections(model.collision, vertices);
  const std::size_t found = pairs.size();
  if (found == 0) return;
  std::ostringstream list;
  for (std::size_t i = 0; i < std::min<std::size_t>(found, 10); ++i)
    list << (i > 0 ? "; " : "") << place(model, pairs[i][0]) << " with "
         << place(model, pairs[i][1]);
  fail<InvalidInput>(
      "the start must be free of intersections, got {} intersecting triangle pairs ({}{}); move "
      "the cloth, or set scene.allow_initial_intersections",
      found, list.str(), found > 10 ? "; ..." : "");
}

void check_inside(const Model& model, const Points& vertices) {
  for (const CollisionSurface& surface : model.collision.surfaces) {
    if (surface.kind == CollisionSurface::Kind::Cloth) continue;
    const bool body = surface.kind == CollisionSurface::Kind::Body;
    const std::size_t index =
        &surface - model.collision.surfaces.data() - model.scene.cloths.size();
    const TriangleMesh& mesh = body
                                   ? *model.scene.bodies[index].mesh
                                   : *model.scene.obstacles[index - model.scene.bodies.size()].mesh;
    if (!mesh.closed()) continue;
    const Points at = vertices.middleRows(surface.first_vertex, surface.n_vertices);
    const Vec3 low = at.colwise().minCoeff(), high = at.colwise().maxCoeff();
    const SpatialQuery query(at, mesh.triangles());
    for (std::size_t user = 0; user < model.row_of_vertex.size(); ++user) {
      const Vec3 p = vertices.row(model.row_of_vertex[user]);
      if ((p.array() < low.array()).any() || (p.array() > high.array()).any() || !query.inside(p))
        continue;
      const Index c = cloth_of_vertex(model, user);
      std::ostringstream out;
      out << "cloth must start outside of closed surfaces: vertex " << vertex_in_cloth(model, user)
          << " of " << model.topology.cloth_names[c] << " at (" << p.transpose()
          << ") m lies inside " << surface.name << "; move one of them";
      throw InvalidInput(out.str());
    }
  }
}

// Throws InvalidInput if, at time 0, a script places a vertex more than the mean edge length of its
// cloth away from its start position, because the first step would then move it far from its
// neighbours.
void check_scripts(const Model& model, const State& state) {
  Points start;
  pin_targets(model, state, 0.0, 1.0, start);
  std::vector<double> edges;
  for (const Cloth& cloth : model.scene.cloths) edges.push_back(cloth.mesh->mean_edge());
  for (std::size_t user = 0; user < model.row_of_vertex.size(); ++user) {
    const Index row = model.row_of_vertex[user], c = cloth_of_vertex(model, user);
    const double away = (start.row(row) - state.cloth.x.row(row)).norm(), edge = edges[c];
    if (away <= edge) continue;
    std::ostringstream out;
    out << item("cloths", c, model.scene.cloths[c].name)
        << ".script_positions must begin where the vertices are (within the mean edge, " << edge
        << " m), but vertex " << vertex_in_cloth(model, user) << " begins " << away
        << " m away; move the mesh or the script";
    throw InvalidInput(out.str());
  }
}

// Sets the flags of prescribed rows and the inverse masses of collision vertices.
void build_freedom(Model& model) {
  model.prescribed = model.cloth.prescribed;
  model.prescribed.resize(model.n_rows(), 0);
  model.inverse_mass = Vector::Zero(model.collision.n_vertices);
  for (Index i = 0; i < model.cloth.n_vertices; ++i)
    model.inverse_mass[i] = model.cloth.prescribed[i] ? 0.0 : 1.0 / model.cloth.mass[i];
}

}  // namespace

void check_start(const Model& model, const State& state) {
  if (model.scene.allow_initial_intersections || !model.scene.collisions ||
      model.cloth.n_vertices == 0)
    return;
  Points vertices;
  collision_vertices(model, state, vertices);
  check_inside(model, vertices);
  check_intersections(model, vertices);
}

void build(const Scene& given, Model& model, State& state) {
  model.scene = given;
  number_names(model.scene);
  const Scene& scene = model.scene;
  check_scene(scene);
  build_cloth(scene, model, state);
  build_bodies(scene, model, state);
  build_magnetics(scene, model);
  state.magnetic.circuits.currents = Vector::Zero(static_cast<Eigen::Index>(scene.coils.size()));
  build_collision(scene, model);
  build_attached_contacts(state, model);
  build_freedom(model);
  check_scripts(model, state);
  check_magnetics(model, state);
  check_start(model, state);
  state.tangled = scene.allow_initial_intersections;
}

}  // namespace loomstone
