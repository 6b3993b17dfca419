// Pairs of features of one surface that may collide, usable without a scene, by three engines that
// give the same pairs.
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
// overlap: all pairs that come closer than twice the inflation are among them. engine: "clusters"
// (our tree), "embree" (its trees, the same boxes), "brute-force". Throws InvalidInput for another
// one, indices out of range, and coordinates that are not finite.
Candidates candidates(const Team& team, const Points& x0, const Points& x1,
                      const Triangles& triangles, double inflation, const std::string& engine);

}  // namespace loomstone
