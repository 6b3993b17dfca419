// Collisions of one surface with itself, found again and again while it moves: trees are formed
// once, then follow the positions.
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
  std::vector<double> vertex_face_time, edge_edge_time;  // the first contact comes no sooner [1]

  double time() const;  // of the first of all [1]; infinity where there is none
};

class Detector {
 public:
  // Throws InvalidInput for negative vertices.
  explicit Detector(const Triangles& triangles);
  Detector(Detector&&) noexcept;
  ~Detector();

  const Edges& edges() const;  // sorted unique vertex pairs

  // Pairs that share no vertex and whose 18-DOPs over the motion x0 -> x1, grown by `inflation`
  // [m], overlap; in ascending order or, faster, in that of the tree. Throws InvalidInput, as the
  // next one, for too few rows and numbers that are not finite.
  FeatureIds candidates(const Team& team, const Points& x0, const Points& x1, double inflation,
                        bool sorted);

  // All pairs that share no vertex and touch while x0 -> x1 on straight lines: exact, closed, with
  // nothing left out.
  Collisions collisions(const Team& team, const Points& x0, const Points& x1);

  void forget_trees();  // forms them anew at the next call: no result depends on it
  std::size_t tree_bytes() const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

// Sorted unique vertex pairs of the triangles.
Edges unique_edges(const Triangles& triangles);

// Both throw InvalidInput.
void check_motion(const Points& x0, const Points& x1, double inflation);
void check_triangles(const Triangles& triangles, Index n_vertices);

}  // namespace loomstone
