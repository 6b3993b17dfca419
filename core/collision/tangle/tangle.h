// Intersections of surfaces and directions that resolve them: edges that pierce triangles, joined
// to intersection contours. Found from positions alone, without history. A part that a contour
// separates goes back the way it came [Baraff2003]; otherwise the contour is shortened
// [Volino2006].
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/base/types.h"
#include "core/collision/model/feature_pairs.h"
#include "core/mesh/adjacency.h"

namespace loomstone {

// An edge that passes through a triangle.
struct Piercing {
  Index edge, triangle;
  std::array<Index, 5> vertices;  // of the edge, then of the triangle
  std::array<double, 5> weights;  // of the common point: + on the edge, - on the triangle; each
                                  // side sums to 1 in magnitude
  int contour = -1;               // index of the first piercing of its contour
  Vec3 way_out = Vec3::Zero();  // unit direction for the edge relative to the triangle; zero: none
  double thickness = 0.0;       // of the pair of surfaces [m]
};

// Everything that intersects in one configuration; a default value means that nothing does.
struct Tangle {
  std::vector<Piercing> piercings;  // sorted by (edge, triangle)
  // Pairs of features of intersecting triangles, by kind, ascending.
  std::array<std::vector<PairKey>, 2> ignored;
  std::vector<int> contour_of_vertex;      // (n) contour near the vertex, -1: none
  std::vector<int> part;                   // (n) part of the surface that this contour separates
  std::vector<std::uint8_t> came_through;  // (n) 1: in the smaller part, which has passed through

  bool empty() const { return piercings.empty(); }
  // Whether contacts and impacts ignore this pair, so that it can pass back: features of two
  // intersecting triangles, or of a part that has come through and its surroundings at the contour.
  bool ignores(const CollisionModel& model, ContactKind kind, PairKey key,
               const std::array<Index, 4>& vertices) const;
};

// Stage: keeps the connectivity of the surfaces.
class TangleFinder {
 public:
  explicit TangleFinder(const CollisionModel& model) : model_(model) {}

  Tangle find(const Points& x);

 private:
  void pierce(const Points& x, Tangle& tangle) const;
  void ignore_pairs(Tangle& tangle) const;
  void join_contours(const Points& x, Tangle& tangle) const;
  // Surfaces cut along a contour.
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
  EdgeTable topology_;  // built when first needed
  Incidence edges_of_vertex_;
};

}  // namespace loomstone
