// Bending of a subset of the triangles of a mesh. The asynchronous integrator gives triangles steps
// of different lengths and evaluates their bending in subsets (level_bending.h). Each of these
// subsets has a vertex numbering of its own. A rank stores mid-edge elements only for its part of
// the mesh (core/parallel/mesh_part.h) and the neighbouring triangles that affect its rows.
#pragma once

#include <vector>

#include "core/cloth/bending/bending.h"
#include "core/parallel/mesh_part.h"

namespace loomstone {

// Bending of a subset of the triangles of a mesh. `setup` contains the acting triangles, for which
// setup.acts is 1, and further triangles on which the curvature of the acting triangles depends.
// setup.forces_only is true.
struct BendingSubset {
  BendingSetup setup;
  std::vector<Index> vertices;  // (k) vertex of the mesh for each vertex of the setup, ascending
};

// Setup of the bending elements that a rank stores. Its vertex indices are those of the whole mesh.
struct BendingOfPart {
  BendingSetup setup;
  // Triangles of the setup whose energies the rank sums.
  IndexRange triangles;
};

// Returns the setup for a part of a mesh. The triangles whose `acts` is 1 include all triangles of
// the part and all triangles whose bending acts on the rows of the part. In these rows, forces and
// stiffness are bitwise identical to those of the whole mesh. `lumped_stiffness` and `keeps_rest`
// are not copied from `whole`.
BendingOfPart bending_of_part(const BendingSetup& whole, MeshPart part);

// Adds to the list `triangles` all triangles of the mesh that share an edge with a triangle in the
// list. On return, the list is sorted and has no duplicates.
void add_neighbours(const EdgeTable& edges, std::vector<Index>& triangles);

// Returns a subset of `whole`, a setup that check_bending_setup() must have accepted. `edges` is
// the edge table of the whole mesh. `acting` lists the acting triangles of the subset in ascending
// order.
BendingSubset bending_subset(const BendingSetup& whole, const EdgeTable& edges,
                             const std::vector<Index>& acting);

}  // namespace loomstone
