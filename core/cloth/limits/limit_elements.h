// Triangles with strain limits ("elements"), grouped by graph colouring. No two elements of a
// colour share a vertex, so all elements of a colour can be corrected in parallel. Up to eight
// elements with the same colour and limit form a batch. The order of batches and lanes depends only
// on the mesh and its limits.
#pragma once

#include <vector>

#include "core/base/aligned.h"
#include "core/base/bytes.h"
#include "core/cloth/limits/limit_kernels.h"
#include "core/cloth/material/strain_limit.h"
#include "core/mesh/triangle_mesh.h"

namespace loomstone {

// Cloth with its strain limits.
struct LimitedCloth {
  Index n_vertices = 0;
  Triangles triangles;            // (m x 3)
  std::vector<Corners2> corners;  // (m) rest coordinates in weft/warp axes [m]
  std::vector<StrainLimit> limits;
  std::vector<Index> limit_of;           // (m) index into limits; -1: unlimited
  Vector mass;                           // (n) masses [kg], > 0
  std::vector<std::uint8_t> prescribed;  // (n) 1: prescribed vertex
};

// Returns a greedy colouring of items: the colour of each item, from 0 to n_colours - 1. Sets
// n_colours to the number of colours. An item is a row of vertex indices. Items are coloured in
// ascending order. Each item gets the smallest colour that differs from those of all preceding
// items that share a vertex with it.
template <class Rows>
std::vector<Index> colours(Index n_vertices, const Rows& items, Index& n_colours) {
  std::vector<Index> start(n_vertices + 1, 0), of_item(items.rows(), -1), stamp;
  for (Index i = 0; i < items.rows(); ++i)
    for (int k = 0; k < items.cols(); ++k) ++start[items(i, k) + 1];
  for (Index v = 0; v < n_vertices; ++v) start[v + 1] += start[v];
  std::vector<Index> list(start[n_vertices]), fill(start.begin(), start.end() - 1);
  for (Index i = 0; i < items.rows(); ++i)
    for (int k = 0; k < items.cols(); ++k) list[fill[items(i, k)]++] = i;
  for (Index i = 0; i < items.rows(); ++i) {
    for (int k = 0; k < items.cols(); ++k)
      for (Index s = start[items(i, k)]; s < start[items(i, k) + 1]; ++s)
        if (const Index c = of_item[list[s]]; c >= 0) stamp[c] = i + 1;
    Index c = 0;
    while (c < static_cast<Index>(stamp.size()) && stamp[c] == i + 1) ++c;
    if (c == static_cast<Index>(stamp.size())) stamp.push_back(0);
    of_item[i] = c;
  }
  n_colours = static_cast<Index>(stamp.size());
  return of_item;
}

// The element tables of strain limiting. Except for the bounds, they change only if the held
// vertices change.
class LimitElements {
 public:
  // If single_rows is true, also builds the tables for limit::correct_one().
  LimitElements(const LimitedCloth& cloth, bool single_rows);

  Index n_batches() const { return static_cast<Index>(bounds_of_.size()); }
  Index n_elements() const { return n_elements_; }
  Index n_triangles() const { return static_cast<Index>(cloth_.triangles.rows()); }
  std::size_t bytes() const {
    return bytes_of(cloth_.triangles, cloth_.corners, cloth_.limit_of, cloth_.mass) +
           bytes_of(held_, also_held_, colour_start_, element_of_, slot_start_, slots_, corners_) +
           bytes_of(bounds_of_, colour_of_, n_in_, gradients_, numbers_, rows_, moves_);
  }
  Index n_elements(Index batch) const { return n_in_[batch]; }
  std::size_t n_limits() const { return bounds_.size(); }
  Index colour(Index batch) const { return colour_of_[batch]; }
  // (colours + 1) First batch of each colour.
  const std::vector<Index>& colour_start() const { return colour_start_; }
  Index element(Index slot) const { return element_of_[slot]; }  // -1: empty lane
  // Slots (see limit::Tables) of the elements at each vertex, in ascending order. Those of vertex v
  // are the entries slot_start()[v] to slot_start()[v + 1] - 1 of slots().
  const std::vector<Index>& slot_start() const { return slot_start_; }
  const std::vector<Index>& slots() const { return slots_; }
  const Corners2& rest_corners(Index triangle) const { return cloth_.corners[triangle]; }
  const Index* corners(Index slot) const {
    return corners_.data() + 24 * static_cast<std::size_t>(slot / 8) + slot % 8;
  }

  // Sets the vertices that corrections do not move: `vertices` and the prescribed vertices. All
  // others may move, also those of earlier calls.
  void hold(const std::vector<Index>& vertices);

  limit::Tables tables() const;
  // Returns the tables for sweeps over elements. Cloths that are limited by edges have infinite
  // bounds in these tables. If `edges` is true, all cloths are limited by edges.
  limit::Tables sweep_tables(bool edges);
  // Returns the tables with bounds of -rate and +rate [1/s] on the strain rates in all modes.
  limit::Tables rate_tables(double rate);

 private:
  void set_element(Index slot);

  LimitedCloth cloth_;
  Index n_elements_ = 0;
  std::vector<std::uint8_t> held_;  // (n) 1: does not move
  std::vector<Index> also_held_;    // vertices of the last call of hold()
  std::vector<Index> colour_start_, element_of_, slot_start_, slots_;
  std::vector<Index> corners_, bounds_of_, colour_of_, n_in_;  // tables of the batches
  AlignedDoubles gradients_, numbers_;
  std::vector<double> rows_;
  std::vector<std::uint8_t> moves_;
  std::vector<limit::Bounds> bounds_, sweep_bounds_, rate_bounds_;
};

}  // namespace loomstone
