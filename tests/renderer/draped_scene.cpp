#include "tests/renderer/draped_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace loomstone {
namespace {

constexpr double ball_radius = 0.15, gap = 0.003, floor_height = -0.30;

// Returns the position [m] of vertex v in a grid of cells x cells cells that covers a square of
// side length `side` [m]. Vertex 0 is at the origin.
Vec2 on_square(Index v, Index cells, double side) {
  const Index column = v % (cells + 1), line = v / (cells + 1);
  return {side * column / cells, side * line / cells};
}

void add_cloth(FrameTopology& topology, Index cells, double side) {
  const Index row = cells + 1;
  topology.cloth_names = {"cloth"};
  topology.cloth_of_vertex.assign(row * row, 0);
  topology.triangles.resize(2 * cells * cells, 3);
  for (Index j = 0; j < cells; ++j) {
    for (Index i = 0; i < cells; ++i) {
      const Index a = j * row + i, b = a + 1, c = a + row + 1, d = a + row, t = 2 * (j * cells + i);
      if ((i + j) % 2 == 0) {
        topology.triangles.row(t) << a, b, c;
        topology.triangles.row(t + 1) << a, c, d;
      } else {
        topology.triangles.row(t) << a, b, d;
        topology.triangles.row(t + 1) << b, c, d;
      }
    }
  }
  topology.cloth_of_triangle.assign(topology.triangles.rows(), 0);
  topology.corner_uv.resize(3 * topology.triangles.rows(), 2);
  for (Index t = 0; t < topology.triangles.rows(); ++t)
    for (int corner = 0; corner < 3; ++corner) {
      const Index v = topology.triangles(t, corner);
      topology.corner_uv.row(3 * t + corner) = on_square(v, cells, side).transpose();
    }
}

void add_body(FrameTopology& topology, Frame& frame, const std::string& name, bool is_floor,
              const std::vector<Vec3>& vertices,
              const std::vector<std::array<Index, 3>>& triangles) {
  const Index body = static_cast<Index>(topology.body_names.size()),
              first = frame.body_vertices.rows(), first_row = topology.body_triangles.rows();
  topology.body_names.push_back(name);
  topology.body_is_floor.push_back(is_floor);
  frame.body_vertices.conservativeResize(first + static_cast<Index>(vertices.size()), 3);
  for (std::size_t i = 0; i < vertices.size(); ++i)
    frame.body_vertices.row(first + i) = vertices[i];
  topology.body_of_vertex.resize(frame.body_vertices.rows(), body);
  topology.body_triangles.conservativeResize(first_row + static_cast<Index>(triangles.size()), 3);
  for (std::size_t i = 0; i < triangles.size(); ++i)
    for (int corner = 0; corner < 3; ++corner)
      topology.body_triangles(first_row + i, corner) = first + triangles[i][corner];
  topology.body_of_triangle.resize(topology.body_triangles.rows(), body);
}

void add_ball(DrapedScene& scene, int subdivisions) {
  const double g = 0.5 * (1.0 + std::sqrt(5.0));
  std::vector<Vec3> v = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                         {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  std::vector<std::array<Index, 3>> t = {
      {0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
      {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
      {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (int level = 0; level < subdivisions; ++level) {
    std::map<std::pair<Index, Index>, Index> middle;
    std::vector<std::array<Index, 3>> finer;
    const auto between = [&](Index a, Index b) {
      const auto [place, fresh] =
          middle.try_emplace(std::minmax(a, b), static_cast<Index>(v.size()));
      if (fresh) v.push_back(0.5 * (v[a] + v[b]));
      return place->second;
    };
    for (const auto& [a, b, c] : t) {
      const Index ab = between(a, b), bc = between(b, c), ca = between(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    t = finer;
    for (Vec3& p : v) p.normalize();
  }
  for (Vec3& p : v) p *= ball_radius / p.norm();
  add_body(scene.topology, scene.frame, "ball", false, v, t);
}

void add_floor(DrapedScene& scene) {
  const double h = floor_height;
  add_body(scene.topology, scene.frame, "floor", true,
           {{-1, -1, h}, {1, -1, h}, {1, 1, h}, {-1, 1, h}}, {{0, 1, 2}, {0, 2, 3}});
}

// Fills strain and stretch with smooth synthetic fields, marks vertices near the ball (or its place
// in a scene without it) as in contact, and sets velocities to zero.
void add_fields(DrapedScene& scene) {
  const FrameTopology& topology = scene.topology;
  Frame& frame = scene.frame;
  const Index m = topology.triangles.rows();
  frame.strain.resize(m, 3);
  frame.stretch.resize(m);
  for (Index t = 0; t < m; ++t) {
    const Vec2 uv = topology.corner_uv.row(3 * t);
    const double r = (uv - Vec2(0.25, 0.25)).norm();
    frame.strain.row(t) << 0.08 * std::exp(-30.0 * r * r), -0.02 + 0.1 * uv.y(),
        0.1 * (uv.x() - 0.25);
    frame.stretch[t] = 1.0 + 0.12 * std::exp(-20.0 * r * r);
  }
  frame.contact.resize(frame.positions.rows());
  for (Index v = 0; v < frame.positions.rows(); ++v)
    frame.contact[v] = frame.positions.row(v).norm() < ball_radius + 2.0 * gap;
  frame.velocities = Points::Zero(frame.positions.rows(), 3);
}

}  // namespace

// The cloth follows the ball from the top to the angle `leaves_at` and then hangs, with folds that
// grow downwards. Up to this angle, the distance r of a point from the middle of the flat cloth
// becomes its arc length from the top of the ball.
DrapedScene draped_scene(Index cells, int subdivisions) {
  DrapedScene scene;
  const double side = 0.62, leaves_at = 1.45;  // leaves_at: angle from the top [rad]
  add_cloth(scene.topology, cells, side);
  const Index row = cells + 1;
  scene.frame.positions.resize(row * row, 3);
  const double radius = ball_radius + gap;
  for (Index v = 0; v < row * row; ++v) {
    const Vec2 p = on_square(v, cells, side) - Vec2::Constant(0.5 * side);
    const double r = p.norm(), around = std::atan2(p.y(), p.x());
    const double angle = std::min(r / radius, leaves_at),
                 hanging = std::max(0.0, r - radius * leaves_at);
    const double depth = std::min(1.0, hanging / 0.1);
    const double fold =
        depth * (0.024 * (1.0 + std::cos(8.0 * around + 0.3)) +
                 0.010 * std::cos(13.0 * around + 1.0) + 0.010 * std::cos(3.0 * around));
    const double out =
        radius * std::sin(angle) + hanging * 0.20 + fold + 0.35 * std::max(0.0, hanging - 0.12);
    const double height = radius * std::cos(angle) - hanging * 0.93;
    scene.frame.positions.row(v) << out * std::cos(around), out * std::sin(around),
        std::max(height, floor_height + 0.004);
  }
  add_ball(scene, subdivisions);
  add_floor(scene);
  add_fields(scene);
  return scene;
}

DrapedScene flat_scene(Index cells) {
  DrapedScene scene;
  add_cloth(scene.topology, cells, 0.5);
  const Index row = cells + 1;
  scene.frame.positions.resize(row * row, 3);
  for (Index v = 0; v < row * row; ++v) {
    const Vec2 p = on_square(v, cells, 0.5) - Vec2::Constant(0.25);
    scene.frame.positions.row(v) << p.x(), 0.0, p.y();
  }
  add_fields(scene);
  return scene;
}

RenderOptions small_options() {
  RenderOptions options;
  options.width = 320;
  options.height = 180;
  return options;
}

std::size_t n_different(const Image& a, const Image& b) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < a.pixels.size(); i += 3)
    count += !std::equal(&a.pixels[i], &a.pixels[i] + 3, &b.pixels[i]);
  return count;
}

}  // namespace loomstone
