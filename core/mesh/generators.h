// Mesh generators. Flat cloth lies in the plane z = 0 and is centred at the origin. Its weft runs
// along x, and its uv are its x and y coordinates. Closed surfaces are oriented outward and, except
// for funnels and wavy bars, centred at the origin. All lengths are in [m].
#pragma once

#include <cstdint>
#include <string>

#include "core/mesh/triangle_mesh.h"

namespace loomstone {

// Rectangle of nx x ny cells with two triangles each. Vertex j (nx + 1) + i is in column i and row
// j. `pattern` is "alternating" (the directions of the diagonals alternate like a checkerboard) or
// "diagonal" (all diagonals run from the lower left to the upper right corner of a cell).
TriangleMesh grid_cells(double width, double height, Index nx, Index ny,
                        const std::string& pattern = "alternating");
// Grid whose numbers of cells are a compromise between square cells and the requested number of
// triangles.
TriangleMesh grid(double width, double height, Index triangles,
                  const std::string& pattern = "alternating");
// Grid whose interior vertices have random (seeded) displacements of up to the fraction `amount` of
// a cell in each coordinate. For unstructured meshes, see python/loomstone/meshes/flat.py.
TriangleMesh jittered_grid(double width, double height, Index nx, Index ny, double amount,
                           std::uint64_t seed = 1);

// Grid with nearly square cells and `cells_across` cells across its width.
TriangleMesh strip(double length, double width, Index cells_across,
                   const std::string& pattern = "alternating");
// Disc of six sectors and `rings` concentric rings, with 6 * rings^2 triangles. Vertex 0 is the
// centre.
TriangleMesh disc(double radius, Index rings);

TriangleMesh icosphere(double radius, int subdivisions);
TriangleMesh box(double x, double y, double z, Index cells_per_side = 1);
// Capsule along z. `length` is the distance between the centres of its caps.
TriangleMesh capsule(double radius, double length, Index segments = 32);
// Cylinder along z, approximated by an inscribed prism.
TriangleMesh cylinder(double radius, double length, Index segments = 32);
// Funnel about the z axis with walls of thickness `wall`. Its inner surface is a cone from
// `top_radius` at z = height to `bottom_radius` at z = 0, and below it a tube of length
// `tube_length`.
TriangleMesh funnel(double top_radius, double bottom_radius, double height, double tube_length,
                    double wall, Index segments = 64);
// Wavy bar along y with hemispherical ends: a tube of radius `radius` whose centre line is a
// sinusoid in the y-z plane. `length` is the distance along y between the ends of the centre line.
TriangleMesh wave_bar(double length, double radius, double amplitude, double wavelength,
                      Index segments = 24);
// Square in the plane z = 0, an open surface with normal +z. Its uv are its x and y coordinates.
TriangleMesh floor_square(double size, Index cells = 8);

}  // namespace loomstone
