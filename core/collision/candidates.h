// Candidate pairs of one surface: features that may collide during a motion. Works without a scene;
// three engines give the same pairs.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/base/types.h"
#include "core/parallel/team.h"

namespace loomstone {

struct Candidates {
  std::vector<std::array<Index, 2>> vertex_face;  // (vertex, triangle), ascending
  std::vector<std::array<Index, 2>>
      edge_edge;  // (edge, edge), smaller first, ascending; an edge is its row of `edges`
  Edges edges;    // sorted unique vertex pairs
};

// Pairs that share no vertex and whose 18-DOPs over the motion x0 -> x1, grown by `inflation` [m],
// overlap. These include all pairs that come closer than twice the inflation. engine: "clusters"
// (ClusterTree), "embree" (Embree's trees over the same boxes) or "brute-force". Throws
// InvalidInput for other engines, indices out of range, and coordinates that are not finite.
Candidates candidates(const Team& team, const Points& x0, const Points& x1,
                      const Triangles& triangles, double inflation, const std::string& engine);

}  // namespace loomstone
