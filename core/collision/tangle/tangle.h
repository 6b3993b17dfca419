// Intersections of surfaces and directions that resolve them. The points at which edges pierce
// triangles are joined to form intersection contours. Contours are found from positions alone,
// without history. If a contour, extended to the border if necessary, separates a part of a
// surface, this part moves back through the other surface [Baraff2003]; if the part is large, its
// whole surface moves back (Retraction). Otherwise the contour is shortened [Volino2006].
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/types.h"
#include "core/collision/model/feature_pairs.h"
#include "core/mesh/adjacency.h"

namespace loomstone {

inline Vec3 point(const Points& x, Index vertex) { return x.row(vertex).transpose(); }

// An edge that passes through a triangle.
struct Piercing {
  Index edge, triangle;
  std::array<Index, 5> vertices;  // ends of the edge, then corners of the triangle
  // Barycentric weights of the common point: those of the edge are >= 0 and sum to 1, and those of
  // the triangle are <= 0 and sum to -1.
  std::array<double, 5> weights;
  int contour = -1;  // smallest index of a piercing of the same contour in Tangle::piercings
  // Unit direction in which the edge must move relative to the triangle, or zero if it is not
  // known.
  Vec3 way_out = Vec3::Zero();
  double thickness = 0.0;  // mean thickness of the two surfaces [m]
  double segment = 0.0;    // half the total length of the contour segments that end here [m]
};

// The surface `inner` is retracted because a large part of it has passed through the surface
// `outer`.
struct Retraction {
  // All vertices of the connected component of which a part has passed through `outer`.
  std::vector<Index> inner;
  // All vertices of the connected component through which this part has passed.
  std::vector<Index> outer;
  int contour = -1;  // Piercing::contour of the contour between `inner` and `outer`
  // Mean of the points where `outer` is pierced by edges that lead into the part that has passed
  // through, weighted by Piercing::segment [m].
  Vec3 point = Vec3::Zero();
  Vec3 direction = Vec3::Zero();  // unit direction in which `inner` moves relative to `outer`
  // Mean width of the part of `inner` that has passed through [m]: the area of this part divided by
  // the length of the contour.
  double depth = 0.0;
};

// Intersections of one configuration. A default-constructed Tangle contains none.
struct Tangle {
  std::vector<Piercing> piercings;  // sorted by (edge, triangle)
  // Feature pairs of intersecting triangles, one list for each ContactKind, in ascending order.
  std::array<std::vector<PairKey>, 2> ignored;
  // (n) Piercing::contour of the contour near the vertex (see `rounds_around` in tangle_parts.cpp)
  // or, if the vertex lies in a part that has passed through a surface, of the contour at the
  // border of this part; -1 if there is none.
  std::vector<int> contour_of_vertex;
  // (n) Index of the part in which the vertex lies after its surface has been cut along the contour
  // in `contour_of_vertex`; -1 if there is no such contour.
  std::vector<int> part;
  std::vector<std::uint8_t> came_through;  // (n) 1: in a part that has passed through a surface
  std::vector<Retraction> retractions;

  bool empty() const { return piercings.empty(); }
  // Returns whether contacts and impacts ignore this pair, so that intersecting surfaces can
  // separate. A pair is ignored if its features belong to two intersecting triangles. It is also
  // ignored if a vertex of one feature and a vertex of the other have the same `contour_of_vertex`
  // but different values of `part`, and at least one of the two has `came_through`. This second
  // rule does not apply to two cloth features if the contour lies on a body or an obstacle.
  bool ignores(const CollisionModel& model, ContactKind kind, PairKey key,
               const std::array<Index, 4>& vertices) const;
};

// Finds the intersections of surfaces that must not intersect; see kept_apart(). Omits pairs of an
// edge and a triangle that share a vertex, or that do not collide because of an attachment. Caches
// the connectivity of the surfaces.
class TangleFinder {
 public:
  explicit TangleFinder(const CollisionModel& model) : model_(model) {}

  Tangle find(const Points& x);
  std::size_t bytes() const { return bytes_of(topology_, edges_of_vertex_, component_); }

 private:
  void pierce(const Points& x, Tangle& tangle) const;
  void ignore_pairs(Tangle& tangle) const;
  void join_contours(const Points& x, Tangle& tangle) const;
  // Result of cutting the surfaces along a contour.
  struct Cut {
    // (edges) 1: the contour crosses the edge an odd number of times.
    std::vector<std::uint8_t> through;
    std::vector<int> part;     // (n) part that contains each vertex; -1: not reached
    std::vector<double> size;  // area of each part [m^2]
  };
  void cut_off(const Points& x, Tangle& tangle) const;
  void cut_along(const Points& x, std::span<Piercing* const> contour,
                 const std::vector<double>& area, Cut& cut, Tangle& tangle) const;
  void retract(const Points& x, std::span<Piercing* const> contour, const std::vector<double>& area,
               const Cut& cut, Tangle& tangle) const;
  static void refine_sizes(const Points& x, std::span<Piercing* const> contour, Cut& cut);
  static int smaller_part(const Piercing& p, const Cut& cut);
  static int smallest_part(std::span<Piercing* const> contour, const Cut& cut);
  void find_components();
  static void drop_opposed(Tangle& tangle);
  void flood(Index start, const std::vector<double>& area, Cut& cut) const;
  void split_by_side(const Points& x, std::span<Piercing* const> contour,
                     const std::vector<double>& area, Cut& cut) const;
  Index other_end(Index edge, Index v) const;
  void widen(const std::vector<int>& part, int contour, Tangle& tangle) const;

  const CollisionModel& model_;
  EdgeTable topology_;  // built when first needed
  Incidence edges_of_vertex_;
  std::vector<int> component_;  // (n) index of the connected component of each vertex
};

}  // namespace loomstone
