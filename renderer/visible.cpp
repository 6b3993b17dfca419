#include "renderer/visible.h"

#include <algorithm>
#include <cstdint>

#include "renderer/scalar_field.h"

namespace loomstone {

FrameTopology shown(const FrameTopology& topology, const RenderOptions& options) {
  FrameTopology rest = topology;
  if (options.hidden.empty()) return rest;
  const std::vector<std::string> hidden = names_in(options.hidden);
  const auto is_hidden = [&](Index body) {
    return std::find(hidden.begin(), hidden.end(), topology.body_names[body]) != hidden.end();
  };
  for (std::size_t body = 0; body < rest.body_is_floor.size(); ++body)
    if (is_hidden(static_cast<Index>(body))) rest.body_is_floor[body] = 0;
  Index n = 0;
  for (Index row = 0; row < topology.body_triangles.rows(); ++row) {
    if (is_hidden(topology.body_of_triangle[row])) continue;
    rest.body_triangles.row(n) = topology.body_triangles.row(row);
    if (topology.body_corner_uv.rows() > 0)
      rest.body_corner_uv.middleRows(3 * n, 3) = topology.body_corner_uv.middleRows(3 * row, 3);
    rest.body_of_triangle[n++] = topology.body_of_triangle[row];
  }
  rest.body_triangles.conservativeResize(n, 3);
  if (topology.body_corner_uv.rows() > 0) rest.body_corner_uv.conservativeResize(3 * n, 2);
  rest.body_of_triangle.resize(n);
  return rest;
}

std::vector<Index> casting_vertices(const FrameTopology& topology) {
  std::vector<std::uint8_t> casts(topology.body_of_vertex.size(), 0);
  for (Index row = 0; row < topology.body_triangles.rows(); ++row)
    if (!topology.body_is_floor[topology.body_of_triangle[row]])
      for (const Index vertex : topology.body_triangles.row(row)) casts[vertex] = 1;
  std::vector<Index> vertices;
  for (std::size_t vertex = 0; vertex < casts.size(); ++vertex)
    if (casts[vertex]) vertices.push_back(static_cast<Index>(vertex));
  return vertices;
}

Plane floor_plane(const FrameTopology& topology, const Points& x, Index body) {
  Vec3 sum = Vec3::Zero(), normal = Vec3::Zero();
  double count = 0.0;
  for (Index row = 0; row < topology.body_triangles.rows(); ++row) {
    if (topology.body_of_triangle[row] != body) continue;
    const Vec3 a = x.row(topology.body_triangles(row, 0)),
               b = x.row(topology.body_triangles(row, 1)),
               c = x.row(topology.body_triangles(row, 2));
    normal += (b - a).cross(c - a);
    sum += a + b + c;
    count += 3.0;
  }
  if (count == 0.0 || normal.norm() == 0.0) return {Vec3::Zero(), Vec3::Zero()};
  if (normal.z() < 0.0) normal = -normal;
  return {sum / count, normal.normalized()};
}

PlaneUv floor_uv(const FrameTopology& topology, const Points& x, Index body) {
  PlaneUv found;
  if (topology.body_corner_uv.rows() == 0) return found;
  std::vector<std::pair<Vec3, Vec2>> corners;
  for (Index row = 0; row < topology.body_triangles.rows(); ++row)
    for (int i = 0; topology.body_of_triangle[row] == body && i < 3; ++i)
      corners.emplace_back(x.row(topology.body_triangles(row, i)),
                           topology.body_corner_uv.row(3 * row + i));
  for (const auto& [place, uv] : corners) {
    found.point += place / static_cast<double>(corners.size());
    found.at_point += uv / static_cast<double>(corners.size());
  }
  Mat3 squares = Mat3::Zero();
  Eigen::Matrix<double, 2, 3> products = found.gradient;
  for (const auto& [place, uv] : corners) {
    squares += (place - found.point) * (place - found.point).transpose();
    products += (uv - found.at_point) * (place - found.point).transpose();
  }
  // The corners of a floor lie in a plane, so `squares` is singular along the normal of the plane.
  found.gradient = products * squares.completeOrthogonalDecomposition().pseudoInverse();
  return found;
}

void Reach::include(const Vec3& point) {
  const Vec3 from_eye = point - view_.eye;
  const double depth = std::max(from_eye.dot(view_.forward), 1e-9);
  const Vec2 at(from_eye.dot(view_.right) / (depth * view_.tangent_x),
                from_eye.dot(view_.up) / (depth * view_.tangent_y));
  low_ = low_.cwiseMin(depth <= view_.near_depth ? Vec2(-1, -1) : at);
  high_ = high_.cwiseMax(depth <= view_.near_depth ? Vec2(1, 1) : at);
}

Rectangle Reach::rectangle() const {
  const auto pixel = [](double at, int size, int extra) {
    return static_cast<int>(
        std::clamp((0.5 * at + 0.5) * size + extra, 0.0, static_cast<double>(size)));
  };
  const int left = pixel(low_.x(), width_, -2),
            bottom = pixel(low_.y(), height_, -2);  // 2 pixels for line width and rounding
  return {left, bottom, pixel(high_.x(), width_, 3) - left, pixel(high_.y(), height_, 3) - bottom};
}

}  // namespace loomstone
