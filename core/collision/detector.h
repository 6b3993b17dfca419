// Self-collision queries on one moving surface. Its tree is kept between queries. Each query refits
// the tree to the given positions, or rebuilds it if its boxes have grown too much.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <vector>

#include "core/base/types.h"
#include "core/parallel/team.h"

namespace loomstone {

struct FeatureIds {
  std::vector<std::array<Index, 2>> vertex_face;  // vertex id, triangle id
  std::vector<std::array<Index, 2>> edge_edge;    // rows of edges(), smaller first
};

struct Collisions {
  FeatureIds pairs;  // in ascending order
  // For each entry of `pairs`, a lower bound on the contact time as a fraction of the motion [1].
  std::vector<double> vertex_face_time, edge_edge_time;

  // Returns the smallest lower bound on a contact time [1], or infinity if there is no collision.
  double time() const;
};

class Detector {
 public:
  // Throws InvalidInput if a vertex index is negative.
  explicit Detector(const Triangles& triangles);
  Detector(Detector&&) noexcept;
  ~Detector();

  const Edges& edges() const;  // sorted unique vertex pairs

  // Returns the pairs that share no vertex and whose 18-DOPs overlap. The 18-DOPs enclose the
  // motion x0 -> x1 and are inflated by `inflation` [m]. If `sorted` is true, the pairs are in
  // ascending order; otherwise they are in tree order, which is faster. Throws InvalidInput if x0
  // and x1 differ in size, have too few rows or are not finite, or if the inflation is negative or
  // not finite.
  FeatureIds candidates(const Team& team, const Points& x0, const Points& x1, double inflation,
                        bool sorted);

  // Returns all pairs that share no vertex and touch while their vertices move from x0 to x1 on
  // straight lines, and lower bounds on their contact times. The test for contact is exact: it has
  // no false negatives and no false positives. Throws InvalidInput under the same conditions as
  // candidates().
  Collisions collisions(const Team& team, const Points& x0, const Points& x1);

  // Makes the next query rebuild the tree. This can change only the order of unsorted candidates.
  void forget_trees();
  std::size_t tree_bytes() const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

// Returns the sorted unique vertex pairs of the triangle edges.
Edges unique_edges(const Triangles& triangles);

// Throws InvalidInput if x0 and x1 differ in size or are not finite, or if the inflation is
// negative or not finite. `name` is the name of `inflation` in the message.
void check_motion(const Points& x0, const Points& x1, double inflation,
                  const char* name = "inflation");
// Throws InvalidInput if a vertex index is negative, or if it is `n_vertices` or more.
void check_triangles(const Triangles& triangles, Index n_vertices);

}  // namespace loomstone
