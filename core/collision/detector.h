// Self-collisions of one surface, for repeated queries while it moves: trees are built once, then
// refitted to the positions.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <vector>

#include "core/base/types.h"
#include "core/parallel/team.h"

namespace loomstone {

struct FeatureIds {
  std::vector<std::array<Index, 2>> vertex_face;  // vertex and triangle
  std::vector<std::array<Index, 2>> edge_edge;    // rows of edges(), smaller first
};

struct Collisions {
  FeatureIds pairs;                                      // ascending
  std::vector<double> vertex_face_time, edge_edge_time;  // lower bounds of first contact times [1]

  double time() const;  // lower bound of the earliest contact [1]; infinity without collisions
};

class Detector {
 public:
  // Throws InvalidInput for negative vertices.
  explicit Detector(const Triangles& triangles);
  Detector(Detector&&) noexcept;
  ~Detector();

  const Edges& edges() const;  // sorted unique vertex pairs

  // Pairs that share no vertex and whose 18-DOPs over the motion x0 -> x1, grown by `inflation`
  // [m], overlap. Sorted: ascending; otherwise in the order of the tree, which is faster. Throws
  // InvalidInput for too few rows and numbers that are not finite, as collisions() does.
  FeatureIds candidates(const Team& team, const Points& x0, const Points& x1, double inflation,
                        bool sorted);

  // All pairs that share no vertex and touch while their points move from x0 to x1 on straight
  // lines. Exact: no pair is missed, none is false; touching counts.
  Collisions collisions(const Team& team, const Points& x0, const Points& x1);

  void forget_trees();  // the next call rebuilds them; results do not depend on it
  std::size_t tree_bytes() const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

// Sorted unique vertex pairs of the triangles.
Edges unique_edges(const Triangles& triangles);

// Both throw InvalidInput where the arguments are unusable.
void check_motion(const Points& x0, const Points& x1, double inflation);
void check_triangles(const Triangles& triangles, Index n_vertices);

}  // namespace loomstone
