// Model of all cloths, which is constant once it has been built. The cloths follow one another in
// the internal vertex order.
#pragma once

#include <vector>

#include "core/base/types.h"
#include "core/cloth/bending/bending.h"
#include "core/cloth/bending/bending_element.h"
#include "core/cloth/material/strain_limit.h"
#include "core/cloth/membrane/membrane.h"
#include "core/mesh/adjacency.h"

namespace loomstone {

struct ClothModel {
  // Bending elements of one kind on a subset of the cloths. Vertex indices refer to the vertices of
  // all cloths.
  struct BendingPart {
    BendingElement element = BendingElement::MidEdge;
    BendingSetup setup;
  };

  Index n_vertices = 0;
  // (cloths + 1) First vertex and first triangle of each cloth.
  std::vector<Index> first_vertex, first_triangle;
  Triangles triangles;                       // (m x 3)
  std::vector<Corners2> corners;             // (m) rest coordinates [m]
  std::vector<MembraneConstants> constants;  // (m)
  std::vector<StrainLimit> strain_limits;
  std::vector<Index> strain_limit_of;  // (m) index into strain_limits; -1: unlimited
  bool limited_by_edges = false;       // strain limits apply to edges of all cloths
  std::vector<BendingPart> bending;
  Vector mass;                           // (n) lumped mass [kg]
  std::vector<std::uint8_t> prescribed;  // (n) 1: prescribed vertex
  Incidence triangles_of_vertex;         // (n)
};

// Returns the lumped mass of each vertex [kg], which is one third of the mass of its incident
// triangles. `density` is given per triangle [kg/m^2].
Vector lumped_mass(Index n_vertices, const Triangles& triangles,
                   const std::vector<Corners2>& corners, const std::vector<double>& density);

}  // namespace loomstone
