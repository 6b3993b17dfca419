// Finds the candidate pairs of one surface. The features of a candidate pair may collide during a
// motion. All inputs are arrays; no scene is needed. There are three search engines, which return
// the same pairs.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/base/types.h"
#include "core/parallel/team.h"

namespace loomstone {

struct Candidates {
  std::vector<std::array<Index, 2>> vertex_face;  // (vertex, triangle), in ascending order
  // (edge, edge), as rows of `edges`, the smaller row first. The pairs are in ascending order.
  std::vector<std::array<Index, 2>> edge_edge;
  Edges edges;  // sorted unique vertex pairs
};

// Returns the edges, and the vertex-face and edge-edge pairs that share no vertex and whose 18-DOPs
// overlap. The 18-DOPs enclose the motion x0 -> x1 and are inflated by `inflation` [m]. All pairs
// that share no vertex and come closer than twice the inflation are among the results. Vertices
// without triangles are ignored. `engine` is "clusters" (ClusterTree), "embree" (Embree's trees
// over the axis slabs of the 18-DOPs) or "brute-force". Throws InvalidInput if the engine is
// unknown, an index is out of range, x0 and x1 differ in size, the inflation is negative, or a
// number is not finite.
Candidates candidates(const Team& team, const Points& x0, const Points& x1,
                      const Triangles& triangles, double inflation, const std::string& engine);

}  // namespace loomstone
