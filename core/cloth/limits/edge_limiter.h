// Edge-based strain limiting (ESL), for comparison: no edge is longer than (1 + bound) times its
// rest length, after [Provot1995] and [Bridson2002]. One bound holds for all directions; the effect
// on shear depends on the mesh.
#pragma once

#include <vector>

#include "core/cloth/limits/limit_elements.h"
#include "core/parallel/team.h"

namespace loomstone {

struct LimitReport;

// Stage.
class EdgeLimiter {
 public:
  explicit EdgeLimiter(const LimitedCloth& cloth);

  // Coloured Gauss-Seidel; counts edges as evaluations. Does not fill the report's excess.
  LimitReport enforce(const Team& team, const LimitOptions& options, const std::vector<Index>& held,
                      Points& x) const;

 private:
  Edges edges_;                                              // (k x 2), colour after colour
  Vector longest_, rest_;                                    // (k) [m]
  std::vector<Index> colour_start_, edge_start_, edges_of_;  // of each vertex
  Vector inverse_mass_;                                      // (n) [1/kg], 0: prescribed
};

}  // namespace loomstone
