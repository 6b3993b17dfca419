// Where surfaces intersect, and the way out: edges that pierce triangles, joined to contours. Found
// from positions alone, without a history. What a contour cuts off goes back the way it came
// [Baraff2003]; where it cuts nothing off, the contour is shortened [Volino2006].
#pragma once

#include <array>
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

class Tangle {
 public:
  explicit Tangle(const CollisionModel& model) : model_(model) {}

  void find(const Points& x);
  void clear();
  bool empty() const { return piercings_.empty(); }
  const std::vector<Piercing>& piercings() const {
    return piercings_;
  }  // sorted by (edge, triangle)

  // Are these features of two triangles that intersect, or of a part that has come through and what
  // is at its contour? Such pairs may pass through each other, and no contact force holds them
  // where they are.
  bool leaves_out(ContactKind kind, PairKey key, const std::array<Index, 4>& vertices) const;

 private:
  void pierce(const Points& x);
  void leave_out();
  void join_contours(const Points& x);
  void cut_off(const Points& x);
  bool is_cloth(Index v) const;
  bool cloth_contour(int contour) const;
  void widen(const std::vector<int>& part, int contour);

  // Two piercings of one pair of triangles are the ends of a segment of a contour.
  struct Segment {
    std::size_t first, second;  // piercings
  };

  const CollisionModel& model_;
  EdgeTable topology_;  // made when first needed
  Incidence edges_of_vertex_;
  std::vector<Piercing> piercings_;
  std::vector<Segment> segments_;
  std::vector<PairKey> left_out_[2];  // by kind, ascending
  std::vector<int> contour_of_vertex_,
      part_;  // (n) -1: at no contour; part of the surface that its contour cuts
  std::vector<std::uint8_t> came_through_;  // (n) in the smaller part
};

}  // namespace loomstone
