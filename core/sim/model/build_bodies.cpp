#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "core/base/message.h"
#include "core/mesh/adjacency.h"
#include "core/sim/model/build.h"
#include "core/sim/model/motion.h"

namespace loomstone {

namespace {

Index first_vertex_of(const Scene& scene, std::size_t cloth) {
  Index first = 0;
  for (std::size_t c = 0; c < cloth; ++c) first += scene.cloths[c].mesh->n_vertices();
  return first;
}

double mean_membrane_stiffness(const Scene& scene) {
  double sum = 0.0;
  for (const Cloth& cloth : scene.cloths)
    sum += 0.5 * (cloth.material.weft_stiffness + cloth.material.warp_stiffness);
  return scene.cloths.empty() ? 300.0 : sum / static_cast<double>(scene.cloths.size());
}

void build_attachments(const Scene& scene, Model& model, const State& state) {
  for (std::size_t a = 0; a < scene.attachments.size(); ++a) {
    const Attachment& attachment = scene.attachments[a];
    const std::string where = formatted("attachments[{}]", a);
    const std::size_t c = find_by_name(scene.cloths, attachment.cloth, where + ".cloth");
    const int body = static_cast<int>(find_by_name(scene.bodies, attachment.body, where + ".body"));
    const Index first = first_vertex_of(scene, c);
    if (attachment.vertices.empty())
      fail<InvalidInput>("{}.vertices must name at least one vertex, got none", where);
    check_vertices(where + ".vertices", attachment.vertices, scene.cloths[c].mesh->n_vertices());
    for (const Index vertex : attachment.vertices) {
      const Index row = model.row_of_vertex[first + vertex];
      if (model.cloth.prescribed[row])
        fail<InvalidInput>("{}.vertices: vertex {} is pinned; unpin it or do not attach it", where,
                           vertex);
      model.attachments.push_back(
          {row, body, to_body(state.rigid, body, state.cloth.x.row(row).transpose())});
    }
  }
  std::sort(model.attachments.begin(), model.attachments.end(), [](const auto& a, const auto& b) {
    return a.row != b.row ? a.row < b.row : a.body < b.body;
  });
  // The factor 100 is our choice. It makes attachments much stiffer than the membrane. With a
  // membrane of 300 N/m, a force of 0.03 N pulls an attached vertex 1 um away from its point on the
  // body.
  model.attachment_stiffness = 100.0 * mean_membrane_stiffness(scene);
}

// Returns the contact distance of a cloth to itself [m]. The default is a tenth of the mean length
// of the sides of triangles, but at most 0.4 times the smallest height of a triangle, because
// features that share no vertex can be as close as this height at rest. Throws InvalidInput if the
// user's value exceeds this height and the cloth collides with itself, because cloth at rest would
// push itself apart.
double own_thickness(const Cloth& cloth, const std::string& name) {
  double smallest = std::numeric_limits<double>::infinity(), edges = 0.0;
  const Points& x = cloth.mesh->vertices();
  const Triangles& t = cloth.mesh->triangles();
  for (Index i = 0; i < t.rows(); ++i) {
    double longest = 0.0;
    for (int k = 0; k < 3; ++k) {
      const double edge = (x.row(t(i, k)) - x.row(t(i, (k + 1) % 3))).norm();
      edges += edge;
      longest = std::max(longest, edge);
    }
    const Vec3 a = (x.row(t(i, 1)) - x.row(t(i, 0))).transpose(),
               b = (x.row(t(i, 2)) - x.row(t(i, 0))).transpose();
    smallest = std::min(smallest, a.cross(b).norm() / longest);
  }
  if (cloth.thickness > smallest && cloth.self_collision) {
    fail<InvalidInput>(
        "{}.thickness must be at most the smallest height of a triangle, {:.6g} m, got {} m: "
        "contact would push neighbouring triangles apart; take a coarser mesh or a smaller "
        "thickness (0: chosen from the mesh)",
        name, smallest, cloth.thickness);
  }
  return cloth.thickness > 0.0
             ? cloth.thickness
             : std::min(0.1 * edges / (3.0 * static_cast<double>(t.rows())), 0.4 * smallest);
}

// Returns whether a surface is closed and has many faces and no creases. The contacts of such a
// surface use interpolated normals instead of face normals.
bool is_smooth(const TriangleMesh& mesh) {
  constexpr Index many_faces = 1000;
  const double crease = std::cos(30.0 * EIGEN_PI / 180.0);
  if (mesh.n_triangles() < many_faces || !mesh.closed()) return false;
  const Triangles& t = mesh.triangles();
  const auto normal = [&](Index i) {
    const Vec3 a = mesh.vertices().row(t(i, 0)), b = mesh.vertices().row(t(i, 1)),
               c = mesh.vertices().row(t(i, 2));
    return Vec3((b - a).cross(c - a).normalized());
  };
  for (const auto& sides : edge_table(mesh.n_vertices(), t).triangles)
    if (normal(sides[0]).dot(normal(sides[1])) < crease) return false;
  return true;
}

void add_surface(CollisionModel& collision, CollisionSurface surface, const Triangles& triangles,
                 Index n_vertices) {
  surface.first_vertex = collision.n_vertices;
  surface.n_vertices = n_vertices;
  surface.first_triangle = static_cast<Index>(collision.triangles.rows());
  surface.n_triangles = static_cast<Index>(triangles.rows());
  collision.triangles.conservativeResize(collision.triangles.rows() + triangles.rows(), 3);
  collision.triangles.bottomRows(triangles.rows()) = triangles.array() + surface.first_vertex;
  collision.n_vertices += n_vertices;
  collision.surfaces.push_back(std::move(surface));
}

void add_cloth_surfaces(const Scene& scene, const std::vector<double>& thickness, Model& model) {
  Index row = 0, triangle = 0;
  for (std::size_t c = 0; c < scene.cloths.size(); ++c) {
    const Cloth& cloth = scene.cloths[c];
    CollisionSurface surface;
    surface.name = model.topology.cloth_names[c];
    surface.kind = CollisionSurface::Kind::Cloth;
    surface.thickness = thickness[c];
    surface.friction = cloth.friction;
    surface.self_collision = cloth.self_collision;
    const Triangles local =
        model.cloth.triangles.middleRows(triangle, cloth.mesh->n_triangles()).array() - row;
    add_surface(model.collision, surface, local, cloth.mesh->n_vertices());
    row += cloth.mesh->n_vertices(), triangle += cloth.mesh->n_triangles();
  }
}

// Adds the surfaces of bodies, then those of obstacles. Surfaces without a given thickness get
// `thickness` [m].
void add_body_surfaces(const Scene& scene, double thickness, Model& model) {
  const auto add = [&](const auto& each, std::size_t number, CollisionSurface surface) {
    surface.name = model.topology.body_names[number];
    surface.thickness = each.thickness > 0.0 ? each.thickness : thickness;
    surface.friction = each.friction;
    surface.smooth = is_smooth(*each.mesh);
    add_surface(model.collision, surface, each.mesh->triangles(), each.mesh->n_vertices());
  };
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    CollisionSurface surface;
    surface.kind = CollisionSurface::Kind::Body;
    surface.body = static_cast<int>(b);
    add(scene.bodies[b], b, surface);
  }
  for (std::size_t o = 0; o < scene.obstacles.size(); ++o) {
    CollisionSurface surface;
    surface.kind = CollisionSurface::Kind::Script;
    add(scene.obstacles[o], scene.bodies.size() + o, surface);
  }
}

// Assigns each collision vertex its row in the implicit solve: for a cloth vertex, its own row; for
// a vertex of a body, the first of the two rows of that body; for a vertex of an obstacle, -1.
void number_rows(Model& model) {
  CollisionModel& collision = model.collision;
  collision.rows.row.assign(collision.n_vertices, -1);
  collision.rows.is_body.assign(collision.n_vertices, 0);
  for (Index i = 0; i < model.cloth.n_vertices; ++i) collision.rows.row[i] = i;
  for (std::size_t b = 0; b < model.bodies.size(); ++b)
    for (Index i = 0; i < model.bodies[b].local.rows(); ++i) {
      const Index vertex = model.bodies[b].first + i;
      collision.rows.row[vertex] = model.cloth.n_vertices + 2 * static_cast<Index>(b);
      collision.rows.is_body[vertex] = 1;
    }
}

// Upper limit of gap_floor() (narrow_phase/continuous.h), the gap that certification keeps open, as
// a fraction of the smallest thickness of a surface. Our choice: well above rounding errors, and
// too small to be seen.
constexpr double gap_floor_of_thickness = 0.004;

double least_thickness(const CollisionModel& model) {
  double least = std::numeric_limits<double>::infinity();
  for (const CollisionSurface& surface : model.surfaces) least = std::min(least, surface.thickness);
  return std::isfinite(least) ? least : 1e-3;
}

// Sets the looks of all bodies and obstacles if any of them has a look, and their uv if any of them
// has a texture.
void set_looks(const Scene& scene, FrameTopology& topology) {
  std::vector<std::pair<const TriangleMesh*, const std::optional<Look>*>> surfaces;
  for (const RigidBody& body : scene.bodies) surfaces.emplace_back(body.mesh.get(), &body.look);
  for (const Obstacle& obstacle : scene.obstacles)
    surfaces.emplace_back(obstacle.mesh.get(), &obstacle.look);
  const auto any = [&](auto holds) {
    return std::any_of(surfaces.begin(), surfaces.end(),
                       [&](const auto& each) { return *each.second && holds(**each.second); });
  };
  if (!any([](const Look&) { return true; })) return;
  for (const auto& [mesh, look] : surfaces) topology.body_looks.push_back(look->value_or(Look{}));
  if (!any([](const Look& look) { return look.texture != nullptr; })) return;
  topology.body_corner_uv = Points2::Zero(topology.body_triangles.size(), 2);
  Index row = 0;
  for (const auto& [mesh, look] : surfaces) {
    const Triangles& corners = mesh->uv_triangles();
    if (*look && (*look)->texture)
      for (Index i = 0; i < corners.size(); ++i)
        topology.body_corner_uv.row(row + i) = mesh->uv().row(corners.data()[i]);
    row += 3 * mesh->n_triangles();
  }
}

}  // namespace

void build_bodies(const Scene& scene, Model& model, State& state) {
  Index next = model.cloth.n_vertices;
  FrameTopology& topology = model.topology;
  Index body_vertex = 0;
  const auto add_topology = [&](const TriangleMesh& mesh, const std::string& name, bool floor) {
    const Index id = static_cast<Index>(topology.body_names.size());
    const Index rows = static_cast<Index>(topology.body_triangles.rows());
    topology.body_triangles.conservativeResize(rows + mesh.n_triangles(), 3);
    topology.body_triangles.bottomRows(mesh.n_triangles()) = mesh.triangles().array() + body_vertex;
    topology.body_of_triangle.insert(topology.body_of_triangle.end(), mesh.n_triangles(), id);
    topology.body_of_vertex.insert(topology.body_of_vertex.end(), mesh.n_vertices(), id);
    topology.body_names.push_back(name);
    topology.body_is_floor.push_back(floor);
    body_vertex += mesh.n_vertices();
  };
  if (!scene.bodies.empty()) {
    RigidWorld world(scene.bodies, {}, scene.gravity);
    state.rigid = world.initial_state();
    model.body_mass = world.mass_properties();
  }
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const TriangleMesh& mesh = *scene.bodies[b].mesh;
    Model::Surface surface;
    surface.first = next;
    surface.local = mesh.vertices().rowwise() - model.body_mass[b].centre.transpose();
    model.bodies.push_back(std::move(surface));
    next += mesh.n_vertices();
    add_topology(mesh, name_of(scene, "body", b, scene.bodies.size(), scene.bodies[b].name), false);
  }
  const std::size_t n_obstacles = scene.obstacles.size();
  state.body_force = state.body_torque = Points::Zero(model.n_bodies(), 3);
  state.pose_override.assign(n_obstacles, 0);
  state.pose_position = Points::Zero(n_obstacles, 3);
  state.pose_orientation.resize(n_obstacles, 4);
  state.pose_orientation.rowwise() = Eigen::RowVector4d(1, 0, 0, 0);
  for (std::size_t o = 0; o < n_obstacles; ++o) {
    const TriangleMesh& mesh = *scene.obstacles[o].mesh;
    model.obstacles.push_back({next, mesh.vertices()});
    next += mesh.n_vertices();
    add_topology(mesh, name_of(scene, "obstacle", o, n_obstacles, scene.obstacles[o].name),
                 scene.obstacles[o].floor);
  }
  set_looks(scene, topology);
  obstacle_vertices(model, state, 0.0, 1.0, state.obstacle_vertices);
  build_attachments(scene, model, state);
}

void build_collision(const Scene& scene, Model& model) {
  std::vector<double> thickness;
  for (std::size_t c = 0; c < scene.cloths.size(); ++c)
    thickness.push_back(own_thickness(scene.cloths[c], item("cloths", c, scene.cloths[c].name)));
  add_cloth_surfaces(scene, thickness, model);
  const double largest =
      thickness.empty() ? 0.0 : *std::max_element(thickness.begin(), thickness.end());
  add_body_surfaces(scene, largest > 0.0 ? largest : 1e-3, model);
  CollisionModel& collision = model.collision;
  collision.gap_floor = gap_floor_of_thickness * least_thickness(collision);
  collision.edges = edge_table(collision.n_vertices, collision.triangles).edges;
  number_rows(model);
  // The factor 3 is our choice. With stiffer contacts, the solver needs more iterations. With
  // softer contacts, surfaces come closer to each other.
  collision.contact_stiffness = scene.contact_stiffness > 0.0
                                    ? scene.contact_stiffness
                                    : 3.0 * mean_membrane_stiffness(scene);
}

}  // namespace loomstone
