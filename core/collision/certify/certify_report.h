// Result of certification: numbers of impacts, and the motion that is withheld to prevent them.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/types.h"

namespace loomstone {

// Displacement that is withheld from a cloth vertex or from the centre of mass of a body, and the
// mass of the vertex or body. A body is identified by its first vertex.
struct WithheldMotion {
  Index vertex;
  Vec3 displacement;  // [m]
  double mass;        // [kg]
};

struct CertifyReport {
  std::int64_t impacts = 0;  // number of impacts before clean-up and withholding
  // Number of impacts that remain after all passes of withholding, for example because prescribed
  // motion leaves the cloth no room. The number includes impacts of cloth with cloth that
  // keep_cloth_from_cloth() in withholding.cpp prevents afterwards.
  std::int64_t unresolved = 0;
  std::vector<WithheldMotion> withheld;  // sorted by vertex, at most one entry per vertex

  // Adds to `withheld` the motion that other certifications or fallbacks of the same step have
  // withheld. Displacements of the same vertex are summed. `others` must be sorted by vertex.
  void merge(const std::vector<WithheldMotion>& others);
  std::int64_t n_withheld() const { return static_cast<std::int64_t>(withheld.size()); }
  double withheld_length() const;  // sum of displacement lengths [m]
  double withheld_moment() const;  // sum of mass times displacement length [kg m]
};

}  // namespace loomstone
