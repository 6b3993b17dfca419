// Edge-based strain limiting after [Provot1995] and [Bridson2002]. It limits the length of every
// edge of a limited triangle to (1 + bound) times the rest length of the edge. The bound does not
// depend on the direction of the edge, so the effect on shear depends on the mesh.
#pragma once

#include <vector>

#include "core/cloth/limits/limit_elements.h"
#include "core/parallel/team.h"

namespace loomstone {

struct LimitReport;

class EdgeLimiter {
 public:
  explicit EdgeLimiter(const LimitedCloth& cloth);

  // Corrects x by coloured Gauss-Seidel sweeps. Prescribed vertices and those listed in `held` do
  // not move. The report contains the numbers of sweeps and of edge evaluations, but no excess.
  LimitReport enforce(const Team& team, const LimitOptions& options, const std::vector<Index>& held,
                      Points& x) const;

 private:
  Edges edges_;            // (k x 2), sorted by colour
  Vector longest_, rest_;  // (k) largest admissible length, and rest length [m]
  // First edge of each colour, followed by k. The edges at vertex v are the entries edge_start_[v]
  // to edge_start_[v + 1] - 1 of edges_of_.
  std::vector<Index> colour_start_, edge_start_, edges_of_;
  Vector inverse_mass_;  // (n) [1/kg], 0: prescribed
};

}  // namespace loomstone
