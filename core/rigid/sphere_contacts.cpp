#include "core/rigid/sphere_contacts.h"

#include <algorithm>

#include "core/mesh/closest_on_triangle.h"

namespace loomstone {

namespace {

constexpr unsigned all_corners = 0b111;

unsigned corners_of(const TrianglePoint& closest) {
  if (closest.feature == TriangleFeature::Face) return all_corners;
  const unsigned corner = 1u << closest.corner;
  return closest.feature == TriangleFeature::Corner ? corner : all_corners & ~corner;
}

}  // namespace

SphereContact sphere_contact(const Vec3& centre, double radius, const Vec3& other_centre, double other_radius) {
  const Vec3 arm = centre - other_centre;
  const double distance = arm.norm();
  const Vec3 normal = distance > 0.0 ? Vec3(arm / distance) : Vec3::UnitX();
  return {centre - radius * normal, other_centre + other_radius * normal, normal, distance - radius - other_radius};
}

double least_gap(const Vec3& centre, double radius, const Vec3& other_centre, double other_radius, const Vec3& motion) {
  const Vec3 arm = centre - other_centre;
  const double squared = motion.squaredNorm();
  const double share = squared > 0.0 ? std::clamp(-arm.dot(motion) / squared, 0.0, 1.0) : 0.0;
  return (arm + share * motion).norm() - radius - other_radius;
}

void SphereOnTriangles::begin(const Vec3& centre, double radius, double reach) {
  centre_ = centre, radius_ = radius, reach_ = reach;
  near_.clear();
}

void SphereOnTriangles::add(const Vec3& a, const Vec3& b, const Vec3& c) {
  const TrianglePoint closest = closest_on_triangle(centre_, a, b, c);
  const double distance = (centre_ - closest.point).norm();
  if (distance <= radius_ + reach_) near_.push_back({{a, b, c}, closest.point, distance, corners_of(closest)});
}

// Nearest on every triangle that shares the part, and told by the first of them.
bool SphereOnTriangles::least_around(const Near& at) const {
  if (at.closest == all_corners) return true;
  const double reach = at.distance * (1.0 + 1e-9);  // what has the part in it is no farther
  for (const Near& other : near_) {
    if (&other == &at || other.distance > reach) continue;
    unsigned shared = 0, met = 0;
    for (int k = 0; k < 3; ++k)
      for (int j = 0; j < 3; ++j)
        if ((at.closest & (1u << k)) && at.corners[k] == other.corners[j]) shared |= 1u << j, met |= 1u << k;
    if (met != at.closest) continue;
    if (other.closest != shared || &other < &at) return false;
  }
  return true;
}

void SphereOnTriangles::contacts(std::size_t most, std::vector<SphereContact>& contacts) {
  least_.clear();
  for (const Near& at : near_)
    if (least_around(at)) least_.push_back(&at);
  std::sort(least_.begin(), least_.end(), [](const Near* a, const Near* b) {
    return a->distance != b->distance ? a->distance < b->distance : a < b;
  });
  if (least_.size() > most) least_.resize(most);
  for (const Near* at : least_) {
    Vec3 normal = centre_ - at->point;
    if (at->distance > 1e-12 * radius_)
      normal /= at->distance;
    else  // but for rounding the centre lies in the surface
      normal = (at->corners[1] - at->corners[0]).cross(at->corners[2] - at->corners[0]).normalized();
    contacts.push_back({centre_ - radius_ * normal, at->point, normal, at->distance - radius_});
  }
}

}  // namespace loomstone
