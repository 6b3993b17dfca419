// Bending of some triangles of a mesh, on its own vertices. Integrators that give triangles steps
// of different lengths evaluate such parts on their own.
#pragma once

#include <vector>

#include "core/cloth/bending/bending.h"

namespace loomstone {

// The setup of the triangles that act, with the neighbours on which their curvature depends. It is
// for forces only.
struct BendingSubset {
  BendingSetup setup;
  std::vector<Index> vertices;  // (k) vertex of the mesh for each vertex of the setup, ascending
};

// Adds the triangles that share an edge with one of `triangles`, and sorts the list.
void add_neighbours(const EdgeTable& edges, std::vector<Index>& triangles);

// Returns the subset of a setup that check_bending_setup() accepts. `edges` belongs to the whole
// mesh, and `acting` lists the triangles that have energy in the subset, ascending.
BendingSubset bending_subset(const BendingSetup& whole, const EdgeTable& edges,
                             const std::vector<Index>& acting);

}  // namespace loomstone
