// All cloths, one after another in the internal order of vertices. Constant once built.
#pragma once

#include <vector>

#include "core/base/types.h"
#include "core/cloth/bending/bending.h"
#include "core/cloth/bending/bending_element.h"
#include "core/cloth/material/strain_limit.h"
#include "core/cloth/membrane/membrane.h"
#include "core/mesh/adjacency.h"

namespace loomstone {

// Model.
struct ClothModel {
  // Bending elements of one kind on some of the cloths; vertex numbers count all cloths.
  struct BendingPart {
    BendingElement element = BendingElement::MidEdge;
    BendingSetup setup;
  };

  Index n_vertices = 0;
  Triangles triangles;                       // (m x 3)
  std::vector<Corners2> corners;             // (m) rest coordinates [m]
  std::vector<MembraneConstants> constants;  // (m)
  std::vector<StrainLimit> strain_limits;
  std::vector<Index> strain_limit_of;  // (m) row of strain_limits, -1: unlimited
  std::vector<BendingPart> bending;
  Vector mass;                           // (n) lumped [kg]
  std::vector<std::uint8_t> prescribed;  // (n) 1: prescribed vertex
  Incidence triangles_of_vertex;         // (n)
};

// Lumped mass: a third of the areas of the incident triangles times their density [kg/m^2].
Vector lumped_mass(Index n_vertices, const Triangles& triangles,
                   const std::vector<Corners2>& corners, const std::vector<double>& density);

}  // namespace loomstone
