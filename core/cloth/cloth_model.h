// Model of all cloths, constant once it has been built. Vertices are in the internal order (see
// Model::row_of_vertex), in which the vertices of each cloth are consecutive.
#pragma once

#include <algorithm>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/types.h"
#include "core/cloth/bending/bending.h"
#include "core/cloth/bending/bending_element.h"
#include "core/cloth/material/strain_limit.h"
#include "core/cloth/membrane/membrane.h"
#include "core/cloth/rest_shapes.h"
#include "core/mesh/adjacency.h"

namespace loomstone {

struct ClothModel {
  // Parameters of the bending of one cloth.
  struct BendingPart {
    BendingElement element = BendingElement::MidEdge;
    Index cloth = 0;
    Mat3 rigidity = Mat3::Zero();  // flexural rigidity D for curvatures (kxx, kyy, 2 kxy) [N m]
    double damping = 0.0;          // beta of stiffness-proportional bending damping [s]
    bool flat_rest = true;         // rest angles of hinges: 0 if true, else those of rest_positions
  };

  Index n_vertices = 0;
  // (cloths + 1) First vertex and first triangle of each cloth, followed by the total numbers.
  std::vector<Index> first_vertex, first_triangle;
  Triangles triangles;                       // (m x 3)
  RestShapes corners;                        // (m) rest coordinates in weft/warp axes [m]
  std::vector<MembraneConstants> constants;  // (cloths)
  std::vector<StrainLimit> strain_limits;
  // (m) Index into strain_limits; -1: unlimited. May be empty if there are no strain limits.
  std::vector<Index> strain_limit_of;
  bool limited_by_edges = false;  // true: the limits of all cloths apply to edges, not to triangles
  std::vector<BendingPart> bending;
  // (n x 3) Initial positions [m] (see BendingSetup::rest_positions); empty: no bending.
  RestPositions rest_positions;
  Vector mass;                           // (n) lumped mass [kg]
  std::vector<std::uint8_t> prescribed;  // (n) 1: prescribed vertex
  Incidence triangles_of_vertex;         // (n) empty: air exerts no drag

  const MembraneConstants& constants_of(Index triangle) const {
    return constants[cloth_of(triangle)];
  }
  Index cloth_of(Index triangle) const {
    const auto next = std::upper_bound(first_triangle.begin(), first_triangle.end(), triangle);
    return static_cast<Index>(next - first_triangle.begin()) - 1;
  }
  // Returns the setup of the bending elements of one cloth. It contains the vertices of all cloths,
  // but only the triangles of this cloth.
  BendingSetup setup_of(const BendingPart& part) const;

  std::size_t bytes() const {
    return bytes_of(first_vertex, first_triangle, triangles, corners, constants, strain_limit_of) +
           bytes_of(bending, rest_positions, mass, prescribed, triangles_of_vertex);
  }
};

// Returns the lumped mass of each vertex, which is one third of the total mass of its incident
// triangles [kg]. `density` is given per triangle [kg/m^2].
Vector lumped_mass(Index n_vertices, const Triangles& triangles,
                   const std::vector<Corners2>& corners, const std::vector<double>& density);

// Returns the rate at which strains beyond their limits may recover [1/s]; infinite if there is no
// cloth. It is the smallest value of sqrt(k / (2 m)) over all cloths. Here, k is the smaller of the
// moduli a11 and a22 (see MembraneConstants), and m is the mean mass of a triangle. Elastic forces
// alone would pull a triangle back at about this rate. Scripts may stretch triangles far beyond
// their limits. If such a triangle recovered within one short part of a step, its vertices would
// get very large velocities.
double recovery_rate(const ClothModel& cloth);

}  // namespace loomstone
