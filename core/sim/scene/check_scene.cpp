#include "core/sim/scene/check_scene.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/base/error.h"
#include "core/base/find_by_name.h"

namespace loomstone {

std::string item(const char* list, std::size_t index, const std::string& name) {
  std::string text = std::string(list) + "[" + std::to_string(index) + "]";
  if (!name.empty()) text += " (\"" + name + "\")";
  return text;
}

std::string name_of(const Scene& scene, const char* kind, std::size_t index, std::size_t count,
                    const std::string& given) {
  if (!given.empty()) return given;
  for (;; index += count) {  // adding `count` avoids the indices of other surfaces of this kind
    const std::string name = kind + std::to_string(index);
    const auto has_it = [&](const auto& list) {
      return std::any_of(list.begin(), list.end(),
                         [&](const auto& each) { return each.name == name; });
    };
    if (!has_it(scene.cloths) && !has_it(scene.bodies) && !has_it(scene.obstacles)) return name;
  }
}

namespace {

void require(bool holds, const std::string& message) {
  if (!holds) throw InvalidInput(message);
}

void check_times(const std::string& where, const std::vector<double>& times) {
  for (std::size_t i = 0; i < times.size(); ++i)
    require(std::isfinite(times[i]) && (i == 0 || times[i] > times[i - 1]),
            where + " must be finite and ascending [s], got " + std::to_string(times[i]) +
                " at entry " + std::to_string(i));
}

void check_rows(const std::string& where, Index got, Index wanted, const std::string& meaning) {
  require(got == wanted, where + " must have " + std::to_string(wanted) + " rows (" + meaning +
                             "), got " + std::to_string(got));
}

void check_finite(const std::string& where, const Points& points) {
  for (Index i = 0; i < points.rows(); ++i)
    require(points.row(i).allFinite(),
            where + " must be finite, row " + std::to_string(i) + " is not");
}

void check_vertices(const std::string& where, const std::vector<Index>& vertices, Index n) {
  const bool mask =
      static_cast<Index>(vertices.size()) == n &&
      std::all_of(vertices.begin(), vertices.end(), [](Index v) { return v == 0 || v == 1; });
  require(!mask, where + " must be vertex indices, got a truth value for each of " +
                     std::to_string(n) + " vertices; give numpy.flatnonzero of it");
  std::set<Index> seen;
  for (const Index v : vertices) {
    require(v >= 0 && v < n, where + " must be vertex indices in [0, " + std::to_string(n - 1) +
                                 "], got " + std::to_string(v));
    require(seen.insert(v).second,
            where + " must name a vertex once, " + std::to_string(v) + " comes twice; remove one");
  }
}

void check_cloth(const Cloth& cloth, const std::string& where) {
  require(cloth.mesh != nullptr, where + ".mesh is missing; give a TriangleMesh");
  check_fields(cloth, where);
  check_fields(cloth.material, where + ".material");
  const double twist = cloth.material.bending_twist;
  require(
      twist >= 0.0 || twist == -1.0,
      where +
          ".material.bending_twist must be >= 0 [N m], or -1 for that of an isotropic plate, got " +
          std::to_string(twist));
  if (cloth.strain_limit) check_fields(*cloth.strain_limit, where + ".strain_limit");
  check_vertices(where + ".pins", cloth.pins, cloth.mesh->n_vertices());
  check_times(where + ".script_times", cloth.script_times);
  check_rows(where + ".script_positions", static_cast<Index>(cloth.script_positions.rows()),
             static_cast<Index>(cloth.script_times.size() * cloth.pins.size()),
             "script_times x pins");
  check_finite(where + ".script_positions", cloth.script_positions);
  if (cloth.velocities.rows() > 0)
    check_rows(where + ".velocities", static_cast<Index>(cloth.velocities.rows()),
               cloth.mesh->n_vertices(), "one a vertex, or none");
  check_finite(where + ".velocities", cloth.velocities);
}

void check_obstacle(const Obstacle& obstacle, const std::string& where) {
  require(obstacle.mesh != nullptr, where + ".mesh is missing; give a TriangleMesh");
  check_fields(obstacle, where);
  check_times(where + ".times", obstacle.times);
  const Index k = static_cast<Index>(obstacle.times.size());
  if (obstacle.positions.rows() > 0)
    check_rows(where + ".positions", static_cast<Index>(obstacle.positions.rows()), k,
               "one a time");
  if (obstacle.axis_angles.rows() > 0)
    check_rows(where + ".axis_angles", static_cast<Index>(obstacle.axis_angles.rows()), k,
               "one a time");
  if (obstacle.vertex_positions.rows() > 0) {
    check_rows(where + ".vertex_positions", static_cast<Index>(obstacle.vertex_positions.rows()),
               k * obstacle.mesh->n_vertices(), "times x vertices");
    require(obstacle.positions.rows() == 0 && obstacle.axis_angles.rows() == 0,
            where + " must move by keyframes or by vertex_positions, got both; drop one");
  }
  require(
      k == 0 || obstacle.positions.rows() + obstacle.axis_angles.rows() +
                        obstacle.vertex_positions.rows() >
                    0,
      where +
          ".times has entries but nothing moves; give positions, axis_angles or vertex_positions");
  check_finite(where + ".positions", obstacle.positions);
  check_finite(where + ".axis_angles", obstacle.axis_angles);
  check_finite(where + ".vertex_positions", obstacle.vertex_positions);
}

template <class List>
void check_names(const char* what, const List& list, std::set<std::string>& seen) {
  for (const auto& each : list)
    require(each.name.empty() || seen.insert(each.name).second,
            std::string(what) + ": the name \"" + each.name +
                "\" is used twice; names tell surfaces apart");
}

}  // namespace

void check_scene(const Scene& scene) {
  check_fields(scene, "scene");
  check_fields(scene.air, "scene.air");
  check_fields(scene.limits, "scene.limits");
  require(scene.gravity.allFinite(), "scene.gravity must be finite");
  require(scene.air.wind.allFinite(), "scene.air.wind must be finite");
  require(!scene.cloths.empty() || !scene.bodies.empty(),
          "scene.cloths is empty and there are no bodies: nothing to simulate");
  std::set<std::string> names;
  check_names("cloths", scene.cloths, names);
  check_names("bodies", scene.bodies, names);
  check_names("obstacles", scene.obstacles, names);
  for (std::size_t i = 0; i < scene.cloths.size(); ++i)
    check_cloth(scene.cloths[i], item("cloths", i, scene.cloths[i].name));
  for (std::size_t i = 0; i < scene.obstacles.size(); ++i)
    check_obstacle(scene.obstacles[i], item("obstacles", i, scene.obstacles[i].name));
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const RigidBody& body = scene.bodies[i];
    const std::string where = item("bodies", i, body.name);
    check_fields(body, where);
    require(body.position.allFinite(), where + ".position must be finite [m]");
    require(body.velocity.allFinite(), where + ".velocity must be finite [m/s]");
    require(body.angular_velocity.allFinite(), where + ".angular_velocity must be finite [rad/s]");
  }
}

}  // namespace loomstone
