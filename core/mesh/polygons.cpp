#include "core/mesh/polygons.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/base/message.h"

namespace loomstone {

namespace {

// A triangle counts as having no area if twice its area is at most this fraction of the sum of the
// squared edge lengths of the polygon. Smaller areas are rounding errors.
constexpr double rounding = 1e-14;

using Fan = std::vector<std::array<int, 3>>;

Fan fan_of(int n) {
  Fan fan;
  for (int k = 2; k < n; ++k) fan.push_back({0, k - 1, k});
  return fan;
}

// Twice the area of a triangle, positive if its corners are counter-clockwise.
double area2(const Vec2& a, const Vec2& b, const Vec2& c) {
  return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
}

// Returns the corners projected onto the plane perpendicular to the polygon's area vector. In this
// plane, the polygon is counter-clockwise.
std::vector<Vec2> flattened(const std::vector<Vec3>& corners, const Vec3& area) {
  const Vec3 n = area.normalized(), u = n.unitOrthogonal(), v = n.cross(u);
  std::vector<Vec2> flat;
  for (const Vec3& corner : corners) {
    const Vec3 from_first = corner - corners[0];
    flat.emplace_back(u.dot(from_first), v.dot(from_first));
  }
  return flat;
}

// Returns whether corner i of the outline `left` is an ear: it forms a counter-clockwise triangle
// with its two neighbours, and no other corner lies in this triangle or, within rounding, on its
// border. Other corners at exactly the position of a corner of this triangle are ignored.
bool is_ear(const std::vector<Vec2>& flat, const std::vector<int>& left, std::size_t i,
            double least) {
  const std::size_t n = left.size(), before = (i + n - 1) % n, after = (i + 1) % n;
  const Vec2 &a = flat[left[before]], &b = flat[left[i]], &c = flat[left[after]];
  if (area2(a, b, c) <= least) return false;
  for (std::size_t k = 0; k < n; ++k) {
    if (k == before || k == i || k == after) continue;
    const Vec2& p = flat[left[k]];
    if (p == a || p == b || p == c) continue;
    if (area2(a, b, p) >= -least && area2(b, c, p) >= -least && area2(c, a, p) >= -least)
      return false;
  }
  return true;
}

}  // namespace

std::vector<std::array<int, 3>> split_polygon(const std::vector<Vec3>& corners) {
  const int n = static_cast<int>(corners.size());
  Fan triangles = fan_of(n);
  if (n <= 3) return triangles;
  Vec3 area = Vec3::Zero();  // twice the area vector
  double squares = 0.0;
  for (int k = 0; k < n; ++k) {
    const Vec3 &here = corners[k], &next = corners[(k + 1) % n];
    area += (here - corners[0]).cross(next - corners[0]);
    squares += (next - here).squaredNorm();
  }
  const double least = rounding * squares;
  // There is no plane to project on if the area vector vanishes or is not finite. If it vanishes
  // although a triangle of the fan has an area, the outline crosses itself, and the result is
  // empty. Otherwise, the fan is returned unchecked, because TriangleMesh rejects triangles without
  // area and coordinates that are not finite.
  if (!(area.norm() > least)) {
    const auto has_area = [&](const std::array<int, 3>& t) {
      const Vec3& origin = corners[t[0]];
      return (corners[t[1]] - origin).cross(corners[t[2]] - origin).norm() > least;
    };
    return std::any_of(triangles.begin(), triangles.end(), has_area) ? Fan() : triangles;
  }
  const std::vector<Vec2> flat = flattened(corners, area);
  const auto lies_right = [&](const std::array<int, 3>& t) {
    return area2(flat[t[0]], flat[t[1]], flat[t[2]]) > least;
  };
  if (std::all_of(triangles.begin(), triangles.end(), lies_right)) return triangles;
  triangles.clear();
  std::vector<int> left(n);
  for (int k = 0; k < n; ++k) left[k] = k;
  for (std::size_t i = 0, tried = 0; left.size() > 2;) {
    i %= left.size();
    if (tried == left.size()) break;
    if (!is_ear(flat, left, i, least)) {
      ++i, ++tried;
      continue;
    }
    const std::size_t size = left.size();
    triangles.push_back({left[(i + size - 1) % size], left[i], left[(i + 1) % size]});
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(i));
    tried = 0;
    ++i;  // the next ear is cut off elsewhere, so that not all triangles share a corner
  }
  double rest = 0.0;  // twice the area that is left
  for (std::size_t k = 2; k < left.size(); ++k) {
    triangles.push_back({left[0], left[k - 1], left[k]});
    rest += area2(flat[left[0]], flat[left[k - 1]], flat[left[k]]);
  }
  // If the outline does not cross itself, the corners that are left coincide or lie on a line.
  return std::abs(rest) <= n * least ? triangles : Fan();
}

Triangles split_polygons(const Points& corners, const std::vector<Index>& start) {
  for (std::size_t p = 0; p < start.size(); ++p)
    require(start[p] >= (p == 0 ? 0 : start[p - 1]) && start[p] <= corners.rows(),
            "start must ascend from 0 to at most {}, got {} as entry {}", corners.rows(), start[p],
            p);
  std::vector<Index> rows;
  std::vector<Vec3> polygon;
  for (std::size_t p = 0; p + 1 < start.size(); ++p) {
    polygon.clear();
    for (Index c = start[p]; c < start[p + 1]; ++c) polygon.push_back(corners.row(c).transpose());
    const Fan triangles = split_polygon(polygon);
    require(!triangles.empty() || polygon.size() < 3,
            "face {}: its outline must not cross itself; correct the mesh", p);
    for (const auto& triangle : triangles)
      for (const int corner : triangle) rows.push_back(start[p] + corner);
  }
  return Eigen::Map<const Triangles>(rows.data(), static_cast<Eigen::Index>(rows.size()) / 3, 3);
}

}  // namespace loomstone
