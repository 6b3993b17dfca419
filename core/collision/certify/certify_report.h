// Result of certification: impacts of the step and the motion withheld to prevent them.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/types.h"

namespace loomstone {

// Part of the displacement of a cloth vertex, or of a body (known by its first vertex), that
// certification withheld.
struct WithheldMotion {
  Index vertex;
  Vec3 displacement;  // [m]
  double mass;        // [kg]
};

struct CertifyReport {
  std::int64_t impacts = 0;     // colliding pairs at the start of certification
  std::int64_t unresolved = 0;  // impacts that remain: prescribed motion leaves the cloth no room
  std::vector<WithheldMotion> withheld;  // ascending, each vertex once

  // Adds motion withheld at another time of the same step; displacements of one vertex are added.
  void merge(const std::vector<WithheldMotion>& others);
  std::int64_t n_withheld() const { return static_cast<std::int64_t>(withheld.size()); }
  double withheld_length() const;  // sum of lengths [m]
  double withheld_moment() const;  // sum of masses times lengths [kg m]
};

}  // namespace loomstone
