#include "core/sim/scene/check_scene.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/base/find_by_name.h"
#include "core/base/message.h"

namespace loomstone {

std::string item(const char* list, std::size_t index, const std::string& name) {
  if (name.empty()) return formatted("{}[{}]", list, index);
  return formatted("{}[{}] (\"{}\")", list, index, name);
}

std::string name_of(const Scene& scene, const char* kind, std::size_t index, std::size_t count,
                    const std::string& given) {
  if (!given.empty()) return given;
  for (;; index += count) {  // adding `count` avoids the indices of other surfaces of this kind
    const std::string name = formatted("{}{}", kind, index);
    const auto has_it = [&](const auto& list) {
      return std::any_of(list.begin(), list.end(),
                         [&](const auto& each) { return each.name == name; });
    };
    if (!has_it(scene.cloths) && !has_it(scene.bodies) && !has_it(scene.obstacles)) return name;
  }
}

namespace {

void check_times(const std::string& where, const std::vector<double>& times) {
  for (std::size_t i = 0; i < times.size(); ++i)
    require(std::isfinite(times[i]) && (i == 0 || times[i] > times[i - 1]),
            "{} must be finite and ascending [s], got {} at entry {}; sort them", where, times[i],
            i);
}

void check_rows(const std::string& where, Index got, Index wanted, const std::string& meaning) {
  require(got == wanted, "{} must have {} rows ({}), got {}", where, wanted, meaning, got);
}

void check_finite(const std::string& where, const Points& points) {
  for (Index i = 0; i < points.rows(); ++i)
    require(points.row(i).allFinite(), "{} must be finite, but row {} is ({:.6g}, {:.6g}, {:.6g})",
            where, i, points(i, 0), points(i, 1), points(i, 2));
}

// Checks the look of an obstacle or body. A texture requires uv, which the meshes of obstacles and
// bodies may lack.
void check_body_look(const std::optional<Look>& look,
                     const std::shared_ptr<const TriangleMesh>& mesh, const std::string& where) {
  if (!look) return;
  check_look(*look, where + ".look");
  require(!look->texture || !mesh || mesh->has_uv(),
          "{}.look.texture needs a mesh with uv, but its mesh has none; give the mesh uv, or a "
          "color instead",
          where);
}

void check_cloth(const Cloth& cloth, const std::string& where) {
  require(cloth.mesh != nullptr, "{}.mesh is missing; give a TriangleMesh", where);
  check_fields(cloth, where);
  check_fields(cloth.material, where + ".material");
  const double twist = cloth.material.bending_twist;
  require(twist >= 0.0 || twist == -1.0,
          "{}.material.bending_twist must be >= 0 [N m], or -1 for Huber's, got {}", where, twist);
  if (cloth.strain_limit) check_fields(*cloth.strain_limit, where + ".strain_limit");
  if (cloth.look) check_look(*cloth.look, where + ".look");
  check_vertices(where + ".pins", cloth.pins, cloth.mesh->n_vertices());
  check_times(where + ".script_times", cloth.script_times);
  check_rows(where + ".script_positions", static_cast<Index>(cloth.script_positions.rows()),
             static_cast<Index>(cloth.script_times.size() * cloth.pins.size()),
             formatted("{} script_times x {} pins", cloth.script_times.size(), cloth.pins.size()));
  check_finite(where + ".script_positions", cloth.script_positions);
  if (cloth.velocities.rows() > 0)
    check_rows(where + ".velocities", static_cast<Index>(cloth.velocities.rows()),
               cloth.mesh->n_vertices(), "one per vertex, or none");
  check_finite(where + ".velocities", cloth.velocities);
}

void check_obstacle(const Obstacle& obstacle, const std::string& where) {
  require(obstacle.mesh != nullptr, "{}.mesh is missing; give a TriangleMesh", where);
  check_fields(obstacle, where);
  check_body_look(obstacle.look, obstacle.mesh, where);
  check_times(where + ".times", obstacle.times);
  const Index k = static_cast<Index>(obstacle.times.size());
  if (obstacle.positions.rows() > 0)
    check_rows(where + ".positions", static_cast<Index>(obstacle.positions.rows()), k,
               "one per time");
  if (obstacle.axis_angles.rows() > 0)
    check_rows(where + ".axis_angles", static_cast<Index>(obstacle.axis_angles.rows()), k,
               "one per time");
  if (obstacle.vertex_positions.rows() > 0) {
    check_rows(where + ".vertex_positions", static_cast<Index>(obstacle.vertex_positions.rows()),
               k * obstacle.mesh->n_vertices(),
               formatted("{} times x {} vertices", k, obstacle.mesh->n_vertices()));
    require(obstacle.positions.rows() == 0 && obstacle.axis_angles.rows() == 0,
            "{} must move by keyframes or by vertex_positions, got both; drop one", where);
  }
  const bool moves = obstacle.positions.rows() > 0 || obstacle.axis_angles.rows() > 0 ||
                     obstacle.vertex_positions.rows() > 0;
  require(k == 0 || moves,
          "{}.times has {} entries but nothing moves; give positions, axis_angles or "
          "vertex_positions",
          where, k);
  check_finite(where + ".positions", obstacle.positions);
  check_finite(where + ".axis_angles", obstacle.axis_angles);
  check_finite(where + ".vertex_positions", obstacle.vertex_positions);
}

template <class List>
void check_names(const char* what, const List& list, std::set<std::string>& seen) {
  for (const auto& each : list)
    require(each.name.empty() || seen.insert(each.name).second,
            "{}: names of surfaces must be unique, got \"{}\" twice; rename one", what, each.name);
}

// Throws InvalidInput if the `body` of an entry of `list` is the name of a surface in `wrong`.
template <class List, class Names>
void check_carriers(const char* what, const List& list, const Names& wrong, const char* kind,
                    const char* remedy) {
  for (std::size_t i = 0; i < list.size(); ++i)
    for (const auto& each : wrong)
      require(each.name.empty() || list[i].body != each.name, "{}[{}].body \"{}\" is {}; {}", what,
              i, each.name, kind, remedy);
}

}  // namespace

void check_vertices(const std::string& where, const std::vector<Index>& vertices, Index n) {
  const bool mask =
      static_cast<Index>(vertices.size()) == n &&
      std::all_of(vertices.begin(), vertices.end(), [](Index v) { return v == 0 || v == 1; });
  require(!mask,
          "{} must be vertex indices, got a truth value for each of {} vertices; give "
          "numpy.flatnonzero of it",
          where, n);
  std::set<Index> seen;
  for (const Index v : vertices) {
    require(v >= 0 && v < n, "{} must be vertex indices in [0, {}], got {}", where, n - 1, v);
    require(seen.insert(v).second, "{} must name each vertex once, got {} twice; remove one", where,
            v);
  }
}

void check_scene(const Scene& scene) {
  check_fields(scene, "scene");
  check_fields(scene.air, "scene.air");
  check_fields(scene.limits, "scene.limits");
  require(scene.gravity.allFinite(), "scene.gravity must be finite [m/s^2]");
  require(scene.air.wind.allFinite(), "scene.air.wind must be finite [m/s]");
  require(!scene.cloths.empty() || !scene.bodies.empty(),
          "the scene must have a cloth or a body, got neither: nothing to simulate");
  std::set<std::string> names;
  check_names("cloths", scene.cloths, names);
  check_names("bodies", scene.bodies, names);
  check_names("obstacles", scene.obstacles, names);
  check_carriers("attachments", scene.attachments, scene.obstacles, "an obstacle",
                 "pin the vertices and move them by script_positions");
  check_carriers("magnets", scene.magnets, scene.cloths, "a cloth",
                 "put the magnet on a rigid body, and attach the cloth to it");
  for (std::size_t i = 0; i < scene.cloths.size(); ++i)
    check_cloth(scene.cloths[i], item("cloths", i, scene.cloths[i].name));
  for (std::size_t i = 0; i < scene.obstacles.size(); ++i)
    check_obstacle(scene.obstacles[i], item("obstacles", i, scene.obstacles[i].name));
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const RigidBody& body = scene.bodies[i];
    const std::string where = item("bodies", i, body.name);
    check_fields(body, where);
    check_body_look(body.look, body.mesh, where);
    require(body.position.allFinite(), "{}.position must be finite [m]", where);
    require(body.velocity.allFinite(), "{}.velocity must be finite [m/s]", where);
    require(body.angular_velocity.allFinite(), "{}.angular_velocity must be finite [rad/s]", where);
  }
}

}  // namespace loomstone
