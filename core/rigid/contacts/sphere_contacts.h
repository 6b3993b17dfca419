// Contacts of spheres with each other and with triangle surfaces: contacts at given positions, and
// first contacts along a straight motion. Independent of Bullet.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "core/base/types.h"

namespace loomstone {

struct SphereContact {
  Vec3 on_sphere, on_other;  // points on the two surfaces [m]
  Vec3 normal;               // unit vector from the other surface to the sphere
  double gap;                // gap along the normal, negative for overlaps [m]
};

// Returns the contact of a sphere with another sphere.
SphereContact sphere_contact(const Vec3& centre, double radius, const Vec3& other_centre,
                             double other_radius);
// Returns the first contact of a sphere with another sphere. The sphere moves by `motion` [m]
// relative to the other one. Returns nothing if the spheres do not meet, or if they overlap at the
// start. The normal is that at the time of contact. The gap along this normal is that at the start
// of the motion.
std::optional<SphereContact> contact_ahead(const Vec3& centre, double radius,
                                           const Vec3& other_centre, double other_radius,
                                           const Vec3& motion);

// A sphere that moves by `motion` [m] in the step.
struct MovingSphere {
  Vec3 centre;
  double radius;
  Vec3 motion;
};

// Finds the contacts of a sphere with a surface of triangles. Contacts are the points where the
// distance from the centre to the surface has a local minimum. A point on an edge or corner counts
// only if it is the closest point of every triangle that shares the edge or corner. Internal edges
// of a flat surface therefore do not block a sphere that rolls over it. Corners of two triangles
// count as the same corner if their coordinates are bitwise equal.
class SphereOnTriangles {
 public:
  // Adds contacts with a gap of at most `near` [m]. If the part of the motion that these contacts
  // do not block is longer than `near`, also adds contacts ahead: those in which the sphere first
  // meets each triangle during this part. If the whole motion is longer than `near`, contacts with
  // a gap above 0.1 `near` that the motion may close are added only if the search ahead finds them.
  // `contacts` must be empty on entry. If there are more than `most` contacts, keeps the earliest
  // contact ahead, if any, then contacts at the start with the most different normals, then further
  // contacts ahead.
  void find(const std::vector<std::array<Vec3, 3>>& triangles, const MovingSphere& sphere,
            double near, std::size_t most, std::vector<SphereContact>& contacts);

 private:
  struct Near {
    Index triangle;
    Vec3 point;
    double distance;   // distance from the centre of the sphere [m]
    unsigned closest;  // bit k: corner k belongs to the closest feature of the triangle
  };
  // Fills near_ with the triangles within `reach` of the position `centre`.
  void find_near(const std::vector<std::array<Vec3, 3>>& triangles, const Vec3& centre,
                 double reach);
  bool least_around(const std::vector<std::array<Vec3, 3>>& triangles, const Near& at) const;
  void find_ahead(const std::vector<std::array<Vec3, 3>>& triangles, const MovingSphere& sphere,
                  double exact);

  std::vector<Near> near_;  // in the order of the triangles
  std::vector<SphereContact> touching_, ahead_;
};

}  // namespace loomstone
