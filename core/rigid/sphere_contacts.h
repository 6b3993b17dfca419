// Where spheres touch one another and surfaces of triangles, or could within a step, before any engine sees it.
#pragma once

#include <vector>

#include "core/base/types.h"

namespace loomstone {

struct SphereContact {
  Vec3 on_sphere, on_other;  // [m]
  Vec3 normal;               // from the other to the sphere, unit length
  double gap;                // negative where they overlap [m]
};

// With another sphere.
SphereContact sphere_contact(const Vec3& centre, double radius, const Vec3& other_centre, double other_radius);
// The least gap while it moves past by `motion` [m].
double least_gap(const Vec3& centre, double radius, const Vec3& other_centre, double other_radius, const Vec3& motion);

// With triangles, told one by one: the places where the centre's distance to their surface has a local minimum. What is
// closest on an edge or a corner of one triangle counts only where it is closest on all that share that edge or corner: a
// sphere that rolls over a plane is not held up by the edges within it.
class SphereOnTriangles {
 public:
  // Contacts are sought up to a gap of `reach` [m]. Forgets what was told before.
  void begin(const Vec3& centre, double radius, double reach);
  void add(const Vec3& a, const Vec3& b, const Vec3& c);
  // Adds the nearest `most`, from the nearest on.
  void contacts(std::size_t most, std::vector<SphereContact>& contacts);

 private:
  struct Near {
    Vec3 corners[3];
    Vec3 point;
    double distance;       // from the centre
    unsigned closest;      // bit k: corner k belongs to the part of the triangle that is closest
  };
  bool least_around(const Near& at) const;

  Vec3 centre_;
  double radius_ = 0.0, reach_ = 0.0;
  std::vector<Near> near_;  // in the order in which they were told
  std::vector<const Near*> least_;
};

}  // namespace loomstone
