#include "core/rigid/contacts/convex_polyhedron.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

namespace loomstone {

namespace {

constexpr double same_plane = 1e-4;  // tolerance for coplanar points, as a fraction of size_of()

double size_of(const std::vector<Vec3>& points, const Vec3& centre) {
  double size = 0.0;
  for (const Vec3& point : points) size = std::max(size, (point - centre).norm());
  return size;
}

}  // namespace

ConvexPolyhedron::ConvexPolyhedron(const std::vector<Vec3>& given,
                                   const std::vector<std::vector<int>>& loops)
    : points(given), centre(Vec3::Zero()) {
  for (const Vec3& point : points) centre += point / static_cast<double>(points.size());
  const double size = size_of(points, centre);
  std::vector<std::pair<Vec3, const std::vector<int>*>> by_area;
  for (const std::vector<int>& loop : loops) {
    Vec3 area = Vec3::Zero();
    for (std::size_t k = 0; k < loop.size(); ++k)
      area += (points[loop[k]] - points[loop[0]])
                  .cross(points[loop[(k + 1) % loop.size()]] - points[loop[0]]);
    by_area.emplace_back(area, &loop);
  }
  std::stable_sort(by_area.begin(), by_area.end(),
                   [](const auto& a, const auto& b) { return a.first.norm() > b.first.norm(); });
  std::map<std::pair<Index, Index>, Index> face_of;  // index of the face of each directed edge
  for (const auto& [area, loop] : by_area) {
    const auto& corners = *loop;
    Face face{area.normalized(), 0.0};
    for (const int corner : corners)
      face.offset += face.normal.dot(points[corner]) / static_cast<double>(corners.size());
    if (face.offset < face.normal.dot(centre)) face = {-face.normal, -face.offset};
    // A face that lies in the plane of a larger one becomes part of it. This includes slivers
    // between coplanar points, which have no well-defined normal.
    auto same = std::find_if(faces.begin(), faces.end(), [&](const Face& other) {
      return std::all_of(corners.begin(), corners.end(), [&](int corner) {
        return std::abs(other.normal.dot(points[corner]) - other.offset) < same_plane * size;
      });
    });
    if (same == faces.end()) {
      const auto outside = [&](const Vec3& point) {
        return face.normal.dot(point) - face.offset > same_plane * size;
      };
      if (area.norm() == 0.0 || std::any_of(points.begin(), points.end(), outside)) continue;
      same = faces.insert(faces.end(), face);
    }
    for (std::size_t k = 0; k < corners.size(); ++k)
      face_of[{corners[k], corners[(k + 1) % corners.size()]}] =
          static_cast<Index>(same - faces.begin());
  }
  for (const auto& [ends, face] : face_of) {
    const auto other = face_of.find({ends.second, ends.first});
    if (ends.first > ends.second || other == face_of.end() || other->second == face) continue;
    edges.push_back({{ends.first, ends.second}, {face, other->second}});
  }
}

std::vector<Vec3> ConvexPolyhedron::corners() const {
  const double close = same_plane * size_of(points, centre);
  std::vector<Vec3> result;
  std::copy_if(points.begin(), points.end(), std::back_inserter(result), [&](const Vec3& point) {
    const auto lies_in = [&](const Face& face) {
      return std::abs(face.normal.dot(point) - face.offset) < close;
    };
    return std::count_if(faces.begin(), faces.end(), lies_in) >= 3;
  });
  return result;
}

ConvexPolyhedron box_polyhedron(const Vec3& half) {
  std::vector<Vec3> points;
  for (int k = 0; k < 8; ++k)
    points.push_back(half.cwiseProduct(Vec3(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1)));
  return {points,
          {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
}

}  // namespace loomstone
