#include "core/rigid/hull_contacts.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace loomstone {

namespace {

constexpr double same_plane = 1e-4;  // sine of the angle up to which planes are one
constexpr double turned_to = 0.98;   // cosine of that up to which a face lies on another: 11 degrees

using Contacts = std::vector<HullContact>;

// Of contacts in one plane: the outermost, the one farthest from it, and those farthest out on either side of the line through
// the two; what bears a body, whatever is a little deeper. What is deeper by a tenth of `near` takes the place of the last.
void keep_corners(Contacts& contacts, double near) {
  if (contacts.size() <= 4) return;
  Vec3 mean = Vec3::Zero();
  for (const HullContact& contact : contacts) mean += contact.point / static_cast<double>(contacts.size());
  const auto bring = [&](std::size_t place, const auto& value) {
    std::swap(contacts[place], *std::max_element(contacts.begin() + static_cast<std::ptrdiff_t>(place), contacts.end(),
                                                 [&](const auto& a, const auto& b) { return value(a) < value(b); }));
  };
  bring(0, [&](const HullContact& c) { return (c.point - mean).squaredNorm(); });
  const Vec3 first = contacts[0].point;
  bring(1, [&](const HullContact& c) { return (c.point - first).squaredNorm(); });
  const Vec3 line = contacts[1].point - first;
  bring(2, [&](const HullContact& c) { return (c.point - first).cross(line).squaredNorm(); });
  const Vec3 side = (contacts[2].point - first).cross(line);
  bring(3, [&](const HullContact& c) { return -side.dot((c.point - first).cross(line)); });
  const auto deeper = [](const HullContact& a, const HullContact& b) { return a.gap < b.gap; };
  const auto kept = contacts.begin() + 4, deepest = std::min_element(kept, contacts.end(), deeper);
  if (deepest != contacts.end() && deepest->gap < std::min_element(contacts.begin(), kept, deeper)->gap - 0.1 * near)
    contacts[3] = *deepest;
  contacts.resize(4);
}

// Of contacts in several planes, of each by turns: the deepest, the one farthest from it, what is left.
void keep_of_each(std::vector<Contacts>& planes, Contacts& kept) {
  for (Contacts& plane : planes) {
    std::iter_swap(plane.begin(), std::min_element(plane.begin(), plane.end(), [](const auto& a, const auto& b) { return a.gap < b.gap; }));
    std::stable_sort(plane.begin() + 1, plane.end(), [&](const auto& a, const auto& b) {
      return (a.point - plane[0].point).squaredNorm() > (b.point - plane[0].point).squaredNorm();
    });
  }
  for (std::size_t turn = 0; kept.size() < 4; ++turn) {
    bool left = false;
    for (const Contacts& plane : planes)
      if (turn < plane.size() && kept.size() < 4) kept.push_back(plane[turn]), left = true;
    if (!left) return;
  }
}

void keep_four(Contacts& contacts, double near) {
  std::vector<Contacts> planes;
  for (const HullContact& contact : contacts) {
    const auto plane = std::find_if(planes.begin(), planes.end(), [&](const Contacts& p) { return p[0].normal.dot(contact.normal) > turned_to; });
    if (plane == planes.end()) {
      planes.push_back({contact});
    } else if (std::none_of(plane->begin(), plane->end(), [&](const HullContact& c) { return c.point == contact.point; })) {
      plane->push_back(contact);  // corners of hulls end several edges
    }
  }
  contacts.clear();
  if (planes.size() == 1) {
    contacts.swap(planes[0]);
    keep_corners(contacts, near);
  } else {
    keep_of_each(planes, contacts);
  }
}

}  // namespace

Polyhedron::Polyhedron(const std::vector<Vec3>& given, const std::vector<std::vector<int>>& loops)
    : points(given), centre(Vec3::Zero()) {
  for (const Vec3& point : points) centre += point / static_cast<double>(points.size());
  std::map<std::pair<Index, Index>, Index> face_of;  // of the directed edges
  for (const std::vector<int>& loop : loops) {
    Vec3 area = Vec3::Zero();
    for (std::size_t k = 0; k < loop.size(); ++k)
      area += (points[loop[k]] - centre).cross(points[loop[(k + 1) % loop.size()]] - centre);
    Vec3 normal = area.normalized();
    double offset = 0.0;
    for (const int corner : loop) offset += normal.dot(points[corner]) / static_cast<double>(loop.size());
    if (offset < normal.dot(centre)) normal = -normal, offset = -offset;
    // A sliver between points of one plane has no direction of its own: it joins a face that it lies in.
    const auto lies_in = [&](const Face& face) {
      return std::all_of(loop.begin(), loop.end(), [&](int corner) {
        return std::abs(face.normal.dot(points[corner]) - face.offset) < same_plane * std::abs(offset - normal.dot(centre));
      });
    };
    auto face = std::find_if(faces.begin(), faces.end(), lies_in);
    if (face == faces.end()) face = faces.insert(faces.end(), {normal, offset});
    for (std::size_t k = 0; k < loop.size(); ++k)
      face_of[{loop[k], loop[(k + 1) % loop.size()]}] = static_cast<Index>(face - faces.begin());
  }
  for (const auto& [ends, face] : face_of) {
    const auto other = face_of.find({ends.second, ends.first});
    if (ends.first > ends.second || other == face_of.end() || other->second == face) continue;
    edges.push_back({{ends.first, ends.second}, {face, other->second}});
  }
}

Polyhedron box_polyhedron(const Vec3& half) {
  std::vector<Vec3> points;
  for (int k = 0; k < 8; ++k) points.emplace_back(k & 1 ? half.x() : -half.x(), k & 2 ? half.y() : -half.y(), k & 4 ? half.z() : -half.z());
  return {points, {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
}

bool HullOnTriangles::reaches_farthest(const Vec3& direction, const Vec3& corner) const {
  for (const auto& triangle : *triangles_) {
    if (std::find(triangle.begin(), triangle.end(), corner) == triangle.end()) continue;
    for (const Vec3& other : triangle)
      if (direction.dot(other - corner) > same_plane * (other - corner).norm()) return false;
  }
  return true;
}

bool HullOnTriangles::reaches_farthest(const Vec3& direction, const Vec3& from, const Vec3& to) const {
  for (const auto& triangle : *triangles_) {
    if (std::find(triangle.begin(), triangle.end(), from) == triangle.end() ||
        std::find(triangle.begin(), triangle.end(), to) == triangle.end())
      continue;
    for (const Vec3& other : triangle)
      if (direction.dot(other - from) > same_plane * (other - from).norm()) return false;
  }
  return true;
}

bool HullOnTriangles::least_overlap(const std::array<Vec3, 3>& triangle, const Vec3& normal, double near, Axis& best) const {
  const Polyhedron& hull = *hull_;
  best = {normal, normal.dot(hull.points[0] - triangle[0])};
  for (const Vec3& point : hull.points) best.gap = std::min(best.gap, normal.dot(point - triangle[0]));
  if (best.gap > near) return false;
  // What does not overlap clearly less than by an axis before is left: contacts stay of one kind.
  const auto better = [&](double gap) { return gap > best.gap + 1e-3 * near + 0.05 * std::abs(best.gap); };
  for (std::size_t f = 0; f < hull.faces.size(); ++f) {
    const auto height = [&](const Vec3& corner) { return hull.faces[f].normal.dot(corner); };
    const Vec3& lowest = *std::min_element(triangle.begin(), triangle.end(), [&](const Vec3& a, const Vec3& b) { return height(a) < height(b); });
    const double gap = height(lowest) - hull.faces[f].offset;
    if (gap > near) return false;
    if (better(gap) && reaches_farthest(-hull.faces[f].normal, lowest))
      best = {-hull.faces[f].normal, gap, static_cast<Index>(f)};
  }
  for (std::size_t e = 0; e < hull.edges.size(); ++e) {
    const auto& [points, faces] = hull.edges[e];
    const Vec3 &from = hull.points[points[0]], along = hull.points[points[1]] - from;
    const Vec3 &first = hull.faces[faces[0]].normal, &second = hull.faces[faces[1]].normal;
    const double turn = first.cross(second).dot(along) > 0.0 ? 1.0 : -1.0;
    for (int side = 0; side < 3; ++side) {
      const Vec3 &start = triangle[side], reach = triangle[(side + 1) % 3] - start;
      Vec3 direction = along.cross(reach);
      const double length = direction.norm();
      if (length < same_plane * along.norm() * reach.norm()) continue;
      direction /= length;
      // The hull is met by this edge in directions between the normals of its two faces, the triangle by its side where the rest
      // lies behind.
      if (direction.dot(first + second) > 0.0) direction = -direction;
      if (turn * direction.cross(first).dot(along) < 0.0 || turn * second.cross(direction).dot(along) < 0.0) continue;
      if (direction.dot(triangle[(side + 2) % 3] - start) > 0.0) continue;
      const double gap = direction.dot(from - start);
      if (gap > near) return false;
      if (!better(gap)) continue;
      // Where the two pass one another.
      const Vec3 between = start - from;
      const double at = between.cross(reach).dot(along.cross(reach)) / (length * length);
      const double share = between.cross(along).dot(along.cross(reach)) / (length * length);
      if (at < 0.0 || at > 1.0 || share < 0.0 || share > 1.0) continue;
      if (reaches_farthest(direction, start, triangle[(side + 1) % 3]))
        best = {direction, gap, -1, static_cast<Index>(e), side, start + share * reach};
    }
  }
  return true;
}

// The ends of what lies of the hull's edges above the triangle.
void HullOnTriangles::clip_hull(const std::array<Vec3, 3>& triangle, const Vec3& normal, double near,
                                std::vector<HullContact>& contacts) const {
  const double turn = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]).dot(normal) > 0.0 ? 1.0 : -1.0;
  for (const auto& edge : hull_->edges) {
    const Vec3 &from = hull_->points[edge.points[0]], &to = hull_->points[edge.points[1]];
    double low = 0.0, high = 1.0;
    const auto keep_below = [&](double at_from, double at_to) {  // the part where a linear function is at most 0
      if (at_from > 0.0 && at_to > 0.0) high = -1.0;
      if (at_from > 0.0 && at_to <= 0.0) low = std::max(low, at_from / (at_from - at_to));
      if (at_from <= 0.0 && at_to > 0.0) high = std::min(high, at_from / (at_from - at_to));
    };
    keep_below(normal.dot(from - triangle[0]) - near, normal.dot(to - triangle[0]) - near);
    const double low_end = low, high_end = high;
    for (int side = 0; side < 3 && low <= high; ++side) {
      const Vec3 out = turn * (triangle[(side + 1) % 3] - triangle[side]).cross(normal);
      keep_below(out.dot(from - triangle[side]), out.dot(to - triangle[side]));
    }
    if (low > high) continue;
    for (const double share : {low, high}) {
      if ((share == low_end && share > 0.0) || (share == high_end && share < 1.0)) continue;  // only as far as is looked
      const Vec3 point = share == 0.0 ? from : share == 1.0 ? to : Vec3(from + share * (to - from));
      const double gap = normal.dot(point - triangle[0]);
      contacts.push_back({point - gap * normal, normal, gap});
    }
  }
}

// The corners of what lies of the triangle below a face of the hull.
void HullOnTriangles::clip_triangle(const std::array<Vec3, 3>& triangle, Index face, const Vec3& normal, double near,
                                    std::vector<HullContact>& contacts) {
  const Polyhedron::Face& below = hull_->faces[face];
  polygon_.assign(triangle.begin(), triangle.end());
  for (const Polyhedron::Face& other : hull_->faces) {
    if (other.normal.dot(below.normal) > turned_to) continue;
    clipped_.clear();
    for (std::size_t k = 0; k < polygon_.size(); ++k) {
      const Vec3 &from = polygon_[k], &to = polygon_[(k + 1) % polygon_.size()];
      const double at_from = other.normal.dot(from) - other.offset, at_to = other.normal.dot(to) - other.offset;
      if (at_from <= 0.0) clipped_.push_back(from);
      if ((at_from <= 0.0) != (at_to <= 0.0)) clipped_.push_back(from + at_from / (at_from - at_to) * (to - from));
    }
    polygon_.swap(clipped_);
  }
  for (const Vec3& point : polygon_) {
    const double gap = (below.normal.dot(point) - below.offset) / -below.normal.dot(normal);
    if (gap <= near) contacts.push_back({point, normal, gap});
  }
}

void HullOnTriangles::find(const Polyhedron& hull, const std::vector<std::array<Vec3, 3>>& triangles, double near,
                           std::vector<HullContact>& contacts) {
  contacts.clear();
  hull_ = &hull, triangles_ = &triangles;
  for (const auto& triangle : triangles) {
    Vec3 normal = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]);
    const double area = normal.norm();
    if (area == 0.0) continue;
    normal /= normal.dot(hull.centre - triangle[0]) < 0.0 ? -area : area;
    Axis axis;
    if (!least_overlap(triangle, normal, near, axis)) continue;
    if (axis.edge >= 0) {
      contacts.push_back({axis.point, axis.direction, axis.gap});
      continue;
    }
    Index face = axis.face;
    if (face < 0) {  // the triangle's own plane is met
      clip_hull(triangle, normal, near, contacts);
      const auto opposite = std::min_element(hull.faces.begin(), hull.faces.end(), [&](const auto& a, const auto& b) {
        return a.normal.dot(normal) < b.normal.dot(normal);
      });
      if (opposite->normal.dot(normal) < -turned_to) face = static_cast<Index>(opposite - hull.faces.begin());
    } else if (axis.direction.dot(normal) > turned_to) {
      clip_hull(triangle, normal, near, contacts);
    }
    if (face >= 0) clip_triangle(triangle, face, axis.direction, near, contacts);
  }
  if (!contacts.empty()) keep_four(contacts, near);
}

}  // namespace loomstone
