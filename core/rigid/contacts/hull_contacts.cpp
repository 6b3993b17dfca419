#include "core/rigid/contacts/hull_contacts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "core/rigid/contacts/contact_reduction.h"
#include "core/rigid/contacts/facing_normals.h"

namespace loomstone {

namespace {

constexpr double zero_sine = 1e-4;  // sine of the largest angle that counts as zero
constexpr double turned_to =
    0.98;  // cosine of 11.5 degrees: directions at smaller angles count as parallel
// Cosine of 45.6 degrees. Only admissible axes at larger angles to the axis of least overlap let
// the hull pass a triangle with which it is flush; for all conditions, see least_overlap().
constexpr double turned_away = 0.7;
constexpr unsigned whole = 7;  // bit mask of all corners of a triangle

int lowest_corner(const HullOnTriangles::Corners& triangle, const Vec3& up) {
  int lowest = 0;
  for (int k = 1; k < 3; ++k)
    if (up.dot(triangle[k] - triangle[lowest]) < 0.0) lowest = k;
  return lowest;
}

// Returns a bit mask of the corner `lowest` and of the other corners that are equally low. There
// are others only if an edge at `lowest`, or the whole triangle, is perpendicular to `up`.
unsigned corners_at(const HullOnTriangles::Corners& triangle, int lowest, const Vec3& up) {
  unsigned corners = 0;
  for (int k = 0; k < 3; ++k) {
    const Vec3 away = triangle[k] - triangle[lowest];
    if (up.dot(away) <= zero_sine * away.norm()) corners |= 1u << k;
  }
  return corners;
}

struct HullEdge {
  HullEdge(const ConvexPolyhedron& hull, std::size_t edge)
      : from(hull.points[hull.edges[edge].points[0]]),
        along(hull.points[hull.edges[edge].points[1]] - from),
        first(hull.faces[hull.edges[edge].faces[0]].normal),
        second(hull.faces[hull.edges[edge].faces[1]].normal) {}
  Vec3 from, along;    // start, and the vector to the end
  Vec3 first, second;  // normals of the two faces
};

// Returns the unit vector from a side of a triangle to an edge of the hull, perpendicular to both,
// or nothing if the two are parallel or cannot have a contact.
std::optional<Vec3> axis_of_edges(const HullEdge& edge, const HullOnTriangles::Corners& triangle,
                                  int side) {
  const Vec3 &start = triangle[side], reach = triangle[(side + 1) % 3] - start;
  const Vec3 across = edge.along.cross(reach);
  const double length = across.norm();
  if (length < zero_sine * edge.along.norm() * reach.norm()) return std::nullopt;
  // An edge of the hull has contacts only in directions between the normals of its faces. A side of
  // the triangle has contacts only in directions away from the triangle.
  const Vec3 direction = across / (across.dot(edge.first + edge.second) > 0.0 ? -length : length);
  const double turn = edge.first.cross(edge.second).dot(edge.along) > 0.0 ? 1.0 : -1.0;
  if (turn * direction.cross(edge.first).dot(edge.along) < 0.0 ||
      turn * edge.second.cross(direction).dot(edge.along) < 0.0 ||
      direction.dot(triangle[(side + 2) % 3] - start) > 0.0)
    return std::nullopt;
  return direction;
}

// Returns the point of a side of a triangle that is nearest to the line of an edge of the hull, if
// the nearest points of the two lines lie on the side and on the edge.
std::optional<Vec3> nearest_on_side(const HullEdge& edge, const HullOnTriangles::Corners& triangle,
                                    int side) {
  const Vec3 &start = triangle[side], reach = triangle[(side + 1) % 3] - start;
  const Vec3 across = edge.along.cross(reach), between = start - edge.from;
  const double length = across.norm();
  const double on_hull = between.cross(reach).dot(across) / (length * length),
               on_side = between.cross(edge.along).dot(across) / (length * length);
  if (on_hull < 0.0 || on_hull > 1.0 || on_side < 0.0 || on_side > 1.0) return std::nullopt;
  return start + on_side * reach;
}

}  // namespace

bool HullOnTriangles::reaches_farthest(const Vec3& direction, std::size_t t, unsigned among) const {
  const int corner = among & 1u ? 0 : among & 2u ? 1 : 2;
  const Vec3& from = (*triangles_)[t][corner];
  const std::array<std::size_t, 3>& corners = shared_.of(t);
  for (const std::size_t k : shared_.triangles_at(corners[corner])) {
    const std::array<std::size_t, 3>& others = shared_.of(k);
    bool shares = true;
    for (int i = 0; i < 3; ++i)
      if (among & (1u << i))
        shares &= std::find(others.begin(), others.end(), corners[i]) != others.end();
    if (!shares) continue;
    for (const Vec3& x : (*triangles_)[k])
      if (direction.dot(x - from) > zero_sine * (x - from).norm()) return false;
  }
  return true;
}

bool HullOnTriangles::least_overlap(const Query& query, std::size_t t, const Vec3& normal,
                                    Axis& best, Axis& met) {
  const Corners& triangle = (*triangles_)[t];
  const double near = query.near;
  flush_along_.clear();
  best = {normal, normal.dot(hull_->points[0] - triangle[0]), -1, -1, true, triangle[0]};
  for (const Vec3& point : hull_->points)
    best.gap = std::min(best.gap, normal.dot(point - triangle[0]));
  if (best.gap > near) return false;
  double apart = best.gap;  // the largest gap along any axis
  met = best;
  // Only an axis of clearly smaller overlap replaces another, so features in contact rarely change.
  const auto better = [&](double gap, const Axis& than) {
    return gap > than.gap + 1e-3 * near + 0.05 * std::abs(than.gap);
  };
  const auto consider = [&](Axis axis, unsigned among) {
    const bool flush = std::abs(axis.gap) <= query.flush;
    if (!flush && !better(axis.gap, met)) return;
    axis.met = among == whole ? axis.direction.dot(normal) > 0.0
                              : reaches_farthest(axis.direction, t, among);
    if (flush && axis.met) flush_along_.push_back(axis.direction);
    if (!better(axis.gap, met)) return;
    if (axis.met) met = axis;
    if (better(axis.gap, best)) best = axis;
  };
  for (std::size_t f = 0; f < hull_->faces.size(); ++f) {
    const ConvexPolyhedron::Face& face = hull_->faces[f];
    const int lowest = lowest_corner(triangle, face.normal);
    const double gap = face.normal.dot(triangle[lowest]) - face.offset;
    if (gap > near) return false;
    apart = std::max(apart, gap);
    consider({-face.normal, gap, static_cast<Index>(f), -1, true, triangle[lowest]},
             corners_at(triangle, lowest, face.normal));
  }
  for (std::size_t e = 0; e < hull_->edges.size(); ++e) {
    const HullEdge edge(*hull_, e);
    for (int side = 0; side < 3; ++side) {
      const auto direction = axis_of_edges(edge, triangle, side);
      if (!direction) continue;
      const double gap = direction->dot(edge.from - triangle[side]);
      if (gap > near) return false;
      apart = std::max(apart, gap);
      if (std::abs(gap) > query.flush && !better(gap, met)) continue;
      if (const auto point = nearest_on_side(edge, triangle, side))
        consider({*direction, gap, -1, static_cast<Index>(e), true, *point},
                 1u << side | 1u << (side + 1) % 3);
    }
  }
  const bool passes =
      best.gap >= -query.flush && std::ranges::any_of(flush_along_, [&](const Vec3& axis) {
        return axis.dot(best.direction) < turned_away;
      });
  return !passes && (best.gap > 0.0 || apart < 0.01 * near);
}

// Clips the edges of the hull to the prism over the triangle. The prism ends at the height `near`
// and has no lower end. Adds contacts at both ends of each remaining part, except at ends that
// result from clipping at this height.
void HullOnTriangles::clip_hull(const Corners& triangle, const Vec3& normal, double near) {
  const double turn =
      (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]).dot(normal) > 0.0 ? 1.0 : -1.0;
  for (const auto& edge : hull_->edges) {
    const Vec3 &from = hull_->points[edge.points[0]], &to = hull_->points[edge.points[1]];
    double low = 0.0, high = 1.0;
    // Keeps the part of the edge where a linear function with these end values is at most 0.
    const auto keep_below = [&](double at_from, double at_to) {
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
      // Ends that result from clipping at the distance `near` are not contacts.
      if ((share == low_end && share > 0.0) || (share == high_end && share < 1.0)) continue;
      const Vec3 point = share == 0.0 ? from : share == 1.0 ? to : Vec3(from + share * (to - from));
      const double gap = normal.dot(point - triangle[0]);
      contacts_.push_back({point - gap * normal, normal, gap});
    }
  }
}

// Clips the triangle with the planes of all hull faces whose normals make an angle of more than
// 11.5 degrees (see turned_to) with that of `face`. Adds contacts at those corners of the result
// whose gap is at most `near`; if `own`, only at corners of the triangle itself.
void HullOnTriangles::clip_triangle(const Corners& triangle, Index face, const Vec3& normal,
                                    double near, bool own) {
  const ConvexPolyhedron::Face& below = hull_->faces[face];
  polygon_.assign(triangle.begin(), triangle.end());
  for (const ConvexPolyhedron::Face& other : hull_->faces) {
    if (other.normal.dot(below.normal) > turned_to) continue;
    clipped_.clear();
    for (std::size_t k = 0; k < polygon_.size(); ++k) {
      const Vec3 &from = polygon_[k], &to = polygon_[(k + 1) % polygon_.size()];
      const double at_from = other.normal.dot(from) - other.offset,
                   at_to = other.normal.dot(to) - other.offset;
      if (at_from <= 0.0) clipped_.push_back(from);
      if ((at_from <= 0.0) != (at_to <= 0.0))
        clipped_.push_back(from + at_from / (at_from - at_to) * (to - from));
    }
    polygon_.swap(clipped_);
  }
  for (const Vec3& point : polygon_) {
    if (own && std::ranges::find(triangle, point) == triangle.end()) continue;
    const double gap = (below.normal.dot(point) - below.offset) / -below.normal.dot(normal);
    if (gap <= near) contacts_.push_back({point, normal, gap});
  }
}

void HullOnTriangles::touch(const Corners& triangle, const Vec3& normal, double near,
                            const Axis& axis) {
  // If the contact direction of two edges is close to the normal of the triangle, the edges are
  // part of an area of contact, which clipping finds as a whole.
  const bool along_normal = axis.direction.dot(normal) > turned_to;
  if (axis.edge >= 0 && !along_normal) {
    contacts_.push_back({axis.point, axis.direction, axis.gap});
    return;
  }
  Index face = axis.face;
  if (face < 0) {  // with the triangle's normal as axis, a hull face may lie flat on the triangle
    const auto opposite = std::min_element(
        hull_->faces.begin(), hull_->faces.end(),
        [&](const auto& a, const auto& b) { return a.normal.dot(normal) < b.normal.dot(normal); });
    if (opposite->normal.dot(normal) < -turned_to)
      face = static_cast<Index>(opposite - hull_->faces.begin());
  }
  // clip_hull() finds all contacts along the normal except those at corners of the triangle, which
  // clip_triangle() finds.
  if (along_normal) clip_hull(triangle, normal, near);
  const bool along_axis = axis.met && axis.edge < 0;
  if (face >= 0)
    clip_triangle(triangle, face, along_axis ? axis.direction : normal, near, along_normal);
}

Vec3 HullOnTriangles::farthest_corner(const Vec3& direction, const Vec3& from) const {
  Vec3 farthest = from;
  for (const Corners& other : *triangles_)
    for (const Vec3& corner : other)
      if (direction.dot(corner - farthest) > 0.0) farthest = corner;
  return farthest;
}

// Treats the triangles one by one. The axis of least overlap of hull and triangle is admissible if
// it is nearly parallel to the triangle's normal, or if Axis::met is true. An admissible axis gives
// contacts at once. An axis that is not admissible gives no contacts if hull and triangle are apart
// along it.
//
// If they overlap along an axis that is not admissible, let o be the overlap of the hull with all
// triangles along this axis, and m the overlap of hull and triangle along the best admissible axis.
// If o <= m, the axis of least overlap gives one candidate for a contact, with the overlap o. If
// o > m, the best admissible axis gives contacts, which are deferred if m is far larger than the
// least overlap.
//
// After all triangles, if no contact overlaps, the candidate with the smallest o becomes a contact,
// and so do the deferred contacts whose m is less than this o. If there is no candidate, all
// deferred contacts become contacts.
void HullOnTriangles::meet_triangles(const Query& query) {
  const std::vector<Corners>& triangles = query.triangles;
  const double near = query.near;
  std::vector<std::pair<std::size_t, Axis>> deep;  // used only if no other contact overlaps
  const std::vector<Vec3> normals =
      facing_normals({triangles, shared_, query.hull.centre, query.before, 2.0 * near});
  HullContact way_out{Vec3::Zero(), Vec3::Zero(), -std::numeric_limits<double>::infinity()};
  for (std::size_t t = 0; t < query.n_met; ++t) {
    const Vec3& normal = normals[t];
    Axis best, met;
    if (normal.isZero() || !least_overlap(query, t, normal, best, met)) continue;
    if (best.met || best.direction.dot(normal) > turned_to) {
      touch(triangles[t], normal, near, best);
      continue;
    }
    if (best.gap > 0.0) continue;
    const Vec3 farthest = farthest_corner(best.direction, best.point);
    const double of_all = best.gap - best.direction.dot(farthest - best.point);
    if (of_all >= met.gap) {
      if (of_all > way_out.gap) way_out = {farthest, best.direction, of_all};
    } else if (met.gap > 3.0 * best.gap - 0.3 * near) {
      touch(triangles[t], normal, near, met);
    } else {
      deep.emplace_back(t, met);
    }
  }
  if (std::none_of(contacts_.begin(), contacts_.end(),
                   [](const HullContact& contact) { return contact.gap < 0.0; })) {
    for (const auto& [t, met] : deep)
      if (met.gap > way_out.gap) touch(triangles[t], normals[t], near, met);
    if (std::isfinite(way_out.gap)) contacts_.push_back(way_out);
  }
}

void HullOnTriangles::find(const Query& query, std::vector<Contacts>& planes) {
  hull_ = &query.hull, triangles_ = &query.triangles;
  contacts_.clear(), planes.clear();
  shared_.find(query.triangles);
  meet_triangles(query);
  for (const HullContact& contact : contacts_) {
    const auto same = [&](const Contacts& plane) {
      return plane[0].normal.dot(contact.normal) > turned_to;
    };
    const auto plane = std::find_if(planes.begin(), planes.end(), same);
    if (plane == planes.end())
      planes.push_back({contact});
    else
      plane->push_back(contact);
  }
  const auto deepest = [](const Contacts& plane) {
    return std::min_element(plane.begin(), plane.end(),
                            [](const auto& a, const auto& b) { return a.gap < b.gap; })
        ->gap;
  };
  std::stable_sort(planes.begin(), planes.end(),
                   [&](const Contacts& a, const Contacts& b) { return deepest(a) < deepest(b); });
  if (planes.size() > query.most) planes.resize(query.most);
  // reduce_contacts() treats gaps that differ by less than `margin` as equal. With the larger
  // margin, a cylinder with many sides would roll on the wrong faces, because the gaps of its
  // neighbouring faces differ by less than this margin. Hulls with at most 64 points get the larger
  // margin, because they then keep their contacts longer.
  const double margin = (hull_->points.size() > 64 ? 0.003 : 0.02) * query.near;
  for (Contacts& plane : planes) reduce_contacts(plane, query.near, margin, query.before);
}

}  // namespace loomstone
