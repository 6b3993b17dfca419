#include "core/rigid/contacts/sphere_contacts.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/mesh/closest_on_triangle.h"

namespace loomstone {

namespace {

constexpr unsigned all_corners = 0b111;
// Largest squared difference between the normals of contacts that count as identical. The value
// corresponds to 0.06 degrees.
constexpr double same_normal = 1e-6;

unsigned corners_of(const TrianglePoint& closest) {
  if (closest.feature == TriangleFeature::Face) return all_corners;
  const unsigned corner = 1u << closest.corner;
  return closest.feature == TriangleFeature::Corner ? corner : all_corners & ~corner;
}

double distance_to(const std::array<Vec3, 3>& triangle, const Vec3& point) {
  return (point - closest_on_triangle(point, triangle[0], triangle[1], triangle[2]).point).norm();
}

// Returns whether the bounding boxes of a triangle and of a sphere of radius `reach` overlap. This
// test is cheaper than computing the distance.
bool may_reach(const std::array<Vec3, 3>& triangle, const Vec3& centre, double reach) {
  for (int k = 0; k < 3; ++k) {
    const double a = triangle[0][k] - centre[k], b = triangle[1][k] - centre[k],
                 c = triangle[2][k] - centre[k];
    if (std::min({a, b, c}) > reach || std::max({a, b, c}) < -reach) return false;
  }
  return true;
}

// Returns the fraction of the motion after which the gap between sphere and triangle is at most
// `exact`. Returns a value above 1 if the gap stays larger during the motion, or if the sphere only
// grazes the triangle. Each iteration advances the sphere by the gap (conservative advancement), so
// the sphere never enters the triangle.
double first_touch(const std::array<Vec3, 3>& triangle, const MovingSphere& sphere, double exact) {
  constexpr int most_steps = 64;  // spheres that need more only graze the triangle
  const double length = sphere.motion.norm();
  double share = 0.0;
  for (int k = 0; k < most_steps && share <= 1.0; ++k) {
    const double gap = distance_to(triangle, sphere.centre + share * sphere.motion) - sphere.radius;
    if (gap <= exact) return share;
    share += gap / length;
  }
  return 2.0;
}

SphereContact contact_at(const Vec3& centre, double radius, const Vec3& point, const Vec3& normal) {
  return {centre - radius * normal, point, normal, (centre - point).dot(normal) - radius};
}

// Keeps at most `most` contacts: the first and then, one by one, the contact whose normal differs
// most from those already kept.
void keep_most_different(std::vector<SphereContact>& contacts, std::size_t most) {
  if (contacts.size() <= most) return;
  for (std::size_t n = 1; n < most; ++n) {
    const auto apart = [&](const SphereContact& contact) {
      double least = 4.0;
      for (std::size_t k = 0; k < n; ++k)
        least = std::min(least, (contact.normal - contacts[k].normal).squaredNorm());
      return least;
    };
    const auto farthest =
        std::max_element(contacts.begin() + static_cast<std::ptrdiff_t>(n), contacts.end(),
                         [&](const auto& a, const auto& b) { return apart(a) < apart(b); });
    std::swap(contacts[n], *farthest);
  }
  contacts.resize(most);
}

}  // namespace

SphereContact sphere_contact(const Vec3& centre, double radius, const Vec3& other_centre,
                             double other_radius) {
  const Vec3 arm = centre - other_centre;
  const double distance = arm.norm();
  const Vec3 normal = distance > 0.0 ? Vec3(arm / distance) : Vec3::UnitX();
  return {centre - radius * normal, other_centre + other_radius * normal, normal,
          distance - radius - other_radius};
}

std::optional<SphereContact> contact_ahead(const Vec3& centre, double radius,
                                           const Vec3& other_centre, double other_radius,
                                           const Vec3& motion) {
  // Solve |arm + share motion| = touching for share.
  const Vec3 arm = centre - other_centre;
  const double touching = radius + other_radius, a = motion.squaredNorm(), b = arm.dot(motion),
               c = arm.squaredNorm() - touching * touching, root = b * b - a * c;
  if (b >= 0.0 || root < 0.0 || c <= 0.0) return std::nullopt;
  const double share = c / (-b + std::sqrt(root));
  if (share > 1.0) return std::nullopt;
  const Vec3 normal = (arm + share * motion) / touching;
  return contact_at(centre, radius, other_centre + other_radius * normal, normal);
}

void SphereOnTriangles::find_near(const std::vector<std::array<Vec3, 3>>& triangles,
                                  const Vec3& centre, double reach) {
  near_.clear();
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (!may_reach(triangles[t], centre, reach)) continue;
    const auto& [a, b, c] = triangles[t];
    const TrianglePoint closest = closest_on_triangle(centre, a, b, c);
    const double distance = (centre - closest.point).norm();
    if (distance <= reach)
      near_.push_back({static_cast<Index>(t), closest.point, distance, corners_of(closest)});
  }
}

// Returns true if at.point is also the closest point of every other triangle that shares the edge
// or corner on which this point lies, and if at.triangle is the first of these triangles in near_.
// Also returns true if the point lies inside its triangle.
bool SphereOnTriangles::least_around(const std::vector<std::array<Vec3, 3>>& triangles,
                                     const Near& at) const {
  if (at.closest == all_corners) return true;
  // Triangles that share the closest feature of `at` are not farther away than `at`.
  const double reach = at.distance * (1.0 + 1e-9);
  for (const Near& other : near_) {
    if (&other == &at || other.distance > reach) continue;
    unsigned shared = 0, met = 0;
    for (int k = 0; k < 3; ++k)
      for (int j = 0; j < 3; ++j)
        if ((at.closest & (1u << k)) && triangles[at.triangle][k] == triangles[other.triangle][j])
          shared |= 1u << j, met |= 1u << k;
    if (met != at.closest) continue;
    if (other.closest != shared || &other < &at) return false;
  }
  return true;
}

// Fills ahead_ with each triangle's first contact along the motion, sorted by time. The sphere is
// in contact when its gap is at most `exact` [m]. A contact counts only if it does not exist at the
// start, if the sphere moves towards it, if its point is a local minimum of the distance from the
// centre to the surface at the time of contact, and if no contact in touching_ has the same normal.
void SphereOnTriangles::find_ahead(const std::vector<std::array<Vec3, 3>>& triangles,
                                   const MovingSphere& sphere, double exact) {
  const auto& [centre, radius, motion] = sphere;
  const double reach = radius + exact + motion.norm();
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (!may_reach(triangles[t], centre, reach)) continue;
    const double share = first_touch(triangles[t], sphere, exact);
    if (share == 0.0 || share > 1.0) continue;
    const Vec3 there = centre + share * motion;
    find_near(triangles, there, radius + 2.0 * exact);
    const auto at = std::find_if(near_.begin(), near_.end(), [&](const Near& n) {
      return n.triangle == static_cast<Index>(t);
    });
    if (at == near_.end() || !least_around(triangles, *at)) continue;
    const Vec3 normal = (there - at->point) / at->distance;
    const auto known = [&](const SphereContact& c) {
      return (c.normal - normal).squaredNorm() < same_normal;
    };
    if (motion.dot(normal) >= 0.0 || std::any_of(touching_.begin(), touching_.end(), known))
      continue;
    ahead_.push_back(contact_at(centre, radius, at->point, normal));
  }
  const auto sooner = [way = motion](const SphereContact& a, const SphereContact& b) {
    return a.gap * -way.dot(b.normal) < b.gap * -way.dot(a.normal);
  };
  std::stable_sort(ahead_.begin(), ahead_.end(), sooner);
}

void SphereOnTriangles::find(const std::vector<std::array<Vec3, 3>>& triangles,
                             const MovingSphere& sphere, double near, std::size_t most,
                             std::vector<SphereContact>& contacts) {
  const auto& [centre, radius, motion] = sphere;
  const bool moves = motion.norm() > near;
  touching_.clear(), ahead_.clear();
  find_near(triangles, centre, radius + near);
  for (const Near& at : near_) {
    if (!least_around(triangles, at)) continue;
    Vec3 normal = centre - at.point;
    if (at.distance > 1e-12 * radius) {
      normal /= at.distance;
    } else {  // the centre lies on the surface, up to rounding
      const auto& [a, b, c] = triangles[at.triangle];
      normal = (b - a).cross(c - a).normalized();
    }
    const SphereContact contact = contact_at(centre, radius, at.point, normal);
    // If the motion is longer than `near`, find_ahead() handles the contacts with a gap above
    // 0.1 `near` whose tangent plane the motion reaches.
    if (!moves || contact.gap <= 0.1 * near || -motion.dot(normal) <= contact.gap)
      touching_.push_back(contact);
  }
  std::stable_sort(touching_.begin(), touching_.end(),
                   [](const auto& a, const auto& b) { return a.gap < b.gap; });
  Vec3 left = motion;  // the motion without the parts that touching contacts block
  for (int pass = 0; pass < 2; ++pass)
    for (const SphereContact& contact : touching_)
      left +=
          std::max(0.0, -left.dot(contact.normal) - std::max(0.0, contact.gap)) * contact.normal;
  if (left.norm() > near) find_ahead(triangles, {centre, radius, left}, 1e-4 * radius);
  keep_most_different(touching_, ahead_.empty() ? most : most - 1);
  contacts.insert(contacts.end(), touching_.begin(), touching_.end());
  for (std::size_t k = 0; k < ahead_.size() && contacts.size() < most; ++k)
    contacts.push_back(ahead_[k]);
}

}  // namespace loomstone
