// Where spheres touch one another and surfaces of triangles, or first will on a straight way,
// before any engine sees it.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "core/base/types.h"

namespace loomstone {

struct SphereContact {
  Vec3 on_sphere, on_other;  // [m]
  Vec3 normal;               // from the other to the sphere, unit length
  double gap;                // along it, negative where they overlap [m]
};

// With another sphere.
SphereContact sphere_contact(const Vec3& centre, double radius, const Vec3& other_centre,
                             double other_radius);
// Where they first touch while the sphere moves past by `motion` [m], seen from where it is now.
std::optional<SphereContact> contact_ahead(const Vec3& centre, double radius,
                                           const Vec3& other_centre, double other_radius,
                                           const Vec3& motion);

// With triangles: the places where the centre's distance to their surface has a local minimum. What
// is closest on an edge or a corner of one triangle counts only where it is closest on all that
// share that edge or corner (whose coordinates are equal bit for bit): a sphere that rolls over a
// plane is not held up by the edges within it.
class SphereOnTriangles {
 public:
  // Adds those with a gap of at most `near`, then those that the sphere first touches while it
  // moves by `motion` [m]; at most `most` in all, of more those whose normals differ most, and one
  // ahead.
  void find(const std::vector<std::array<Vec3, 3>>& triangles, const Vec3& centre, double radius,
            double near, const Vec3& motion, std::size_t most,
            std::vector<SphereContact>& contacts);

 private:
  struct Near {
    Index triangle;
    Vec3 point;
    double distance;   // from the centre
    unsigned closest;  // bit k: corner k belongs to the part of the triangle that is closest
  };
  // Fills near_ with what lies within `reach` of a place of the centre.
  void look(const std::vector<std::array<Vec3, 3>>& triangles, const Vec3& centre, double reach);
  bool least_around(const std::vector<std::array<Vec3, 3>>& triangles, const Near& at) const;
  void find_ahead(const std::vector<std::array<Vec3, 3>>& triangles, const Vec3& centre,
                  double radius, double exact, const Vec3& motion);

  std::vector<Near> near_;  // in the order of the triangles
  std::vector<SphereContact> touching_, ahead_;
};

}  // namespace loomstone
