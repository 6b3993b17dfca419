// Meshes, materials and solves shared by the tests of bending.
#pragma once

#include <string>

#include "core/cloth/bending/bending.h"
#include "core/mesh/triangle_mesh.h"

namespace loomstone::test {

// Rigidity [N m], for curvatures (kxx, kyy, 2 kxy), of a plate with the flexural rigidity b [N m]
// and the Poisson ratio nu.
Mat3 isotropic(double b, double nu);
Mat3 some_rigidity();  // anisotropic rigidity without zeros [N m]

// Setup of a flat mesh in z = 0. The material axes are x and y, rotated about z by `angle` [rad].
BendingSetup flat_setup(const Points& vertices, const Triangles& triangles, const Mat3& rigidity,
                        double angle = 0.0);
BendingSetup flat_setup(const TriangleMesh& mesh, const Mat3& rigidity, double angle = 0.0);

// element: "hinge" | "midedge".
std::unique_ptr<Bending> make_bending(const std::string& element, const BendingSetup& setup);

Points noise(Index n, double size, unsigned seed);

// Strip from x = 0 (the clamp line) to x = length and from y = 0 to y = width, continued a little
// to x < 0. The vertices at x <= 0 are prescribed and form at least two rows along y.
struct Strip {
  Points vertices;
  Triangles triangles;
  std::vector<std::uint8_t> prescribed;
  std::vector<Index> tip;  // vertices at x = length
  double length;
};
// pattern: alternating | diagonal | mirrored | jittered | along | across. The last two consist of
// diamonds with edges at about 45 degrees to the strip. Each diamond is divided by a diagonal along
// or across the strip; on the clamp line, it always runs across. The parameter `across` is the
// number of cells across the width.
Strip make_strip(const std::string& pattern, double length, double width, Index across);
// Strip that is a random_mesh() (delaunay.h) after `smoothing` rounds of smoothing (0 keeps
// slivers), with a column of cells added behind the clamp line. Writes the smallest angle of the
// random mesh [rad] to least_angle unless this pointer is null.
Strip random_strip(double length, double width, Index across, unsigned seed, int smoothing,
                   double* least_angle = nullptr);

Vector lumped_areas(const Points& vertices, const Triangles& triangles);  // [m^2]

// Returns the deflections [m] of a flat sheet under a load of 1 N/m^2, from a linear solve.
Vector deflections(const Points& vertices, const Triangles& triangles,
                   const std::vector<std::uint8_t>& prescribed, const Bending& bending);
// Mean deflection at the tip of a strip [m].
double tip_deflection(const Strip& strip, const Bending& bending);

}  // namespace loomstone::test
