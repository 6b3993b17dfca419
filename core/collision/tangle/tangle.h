// Where surfaces intersect, and the way out: edges that pierce triangles, joined to contours. Found
// from positions alone, without a history. What a contour cuts off goes back the way it came
// [Baraff2003]; where it cuts nothing off, the contour is shortened [Volino2006].
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/base/types.h"
#include "core/collision/model/feature_pairs.h"
#include "core/mesh/adjacency.h"

namespace loomstone {

struct Piercing {
  Index edge, triangle;
  std::array<Index, 5> vertices;  // of the edge, then of the triangle
  std::array<double, 5>
      weights;  // of the point they share: + on the edge, - on the triangle; each side sums to 1
  int contour = -1;             // index of its first piercing
  Vec3 way_out = Vec3::Zero();  // unit: where the edge should go relative to the triangle; zero:
                                // nowhere by itself
  double thickness = 0.0;       // of the pair of surfaces [m]
};

struct Tangle {
  std::vector<Piercing> piercings;  // sorted by (edge, triangle)
  std::array<std::vector<PairKey>, 2>
      ignored;                         // by kind, ascending: features of triangles that intersect
  std::vector<int> contour_of_vertex;  // (n) -1: near none; empty: nothing intersects
  std::vector<int> part;               // (n) part of the surface that the contour cuts
  std::vector<std::uint8_t> came_through;  // (n) in the smaller part

  bool empty() const { return piercings.empty(); }
  // Are these features of two triangles that intersect, or of a part that has come through and what
  // is at its contour? Such pairs may pass through each other, and no contact force holds them
  // where they are.
  bool leaves_out(const CollisionModel& model, ContactKind kind, PairKey key,
                  const std::array<Index, 4>& vertices) const;
};

// Stage: keeps the topology of the surfaces.
class TangleFinder {
 public:
  explicit TangleFinder(const CollisionModel& model) : model_(model) {}

  Tangle find(const Points& x);

 private:
  void pierce(const Points& x, Tangle& tangle) const;
  void ignore_pairs(Tangle& tangle) const;
  void join_contours(const Points& x, Tangle& tangle) const;
  // The surface cut along a contour.
  struct Cut {
    std::vector<std::uint8_t> through;  // of edges: cut an odd number of times
    std::vector<int> part;              // of vertices, -1: not reached
    std::vector<double> size;           // of parts [m^2]
  };
  void cut_off(const Points& x, Tangle& tangle) const;
  void cut_along(const Points& x, std::span<Piercing* const> contour,
                 const std::vector<double>& area, Cut& cut, Tangle& tangle) const;
  void flood(Index start, const std::vector<double>& area, Cut& cut) const;
  Index other_end(Index edge, Index v) const;
  void widen(const std::vector<int>& part, int contour, Tangle& tangle) const;

  const CollisionModel& model_;
  EdgeTable topology_;  // made when first needed
  Incidence edges_of_vertex_;
};

}  // namespace loomstone
