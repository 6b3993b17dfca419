// Meshes made from numbers. Flat cloth lies in z = 0, centred at the origin, weft along x, with its
// coordinates as uv; closed surfaces are centred (but the funnel) and point outward. All lengths in
// [m].
#pragma once

#include <cstdint>
#include <string>

#include "core/mesh/triangle_mesh.h"

namespace loomstone {

// Rectangle of nx x ny cells, two triangles each; vertex j (nx + 1) + i lies at column i, row j.
// pattern: "alternating" (diagonals alternate like a checkerboard) | "diagonal" (all along +45
// degrees).
TriangleMesh grid_cells(double width, double height, Index nx, Index ny,
                        const std::string& pattern = "alternating");
// The nx, ny whose 2 nx ny is nearest to `triangles` with square cells.
TriangleMesh grid(double width, double height, Index triangles,
                  const std::string& pattern = "alternating");
// Grid whose interior vertices are displaced at random by up to `amount` of a cell (seeded):
// irregular but valid. Quality unstructured meshes (Delaunay of relaxed points) are made in Python
// with scipy.
TriangleMesh jittered_grid(double width, double height, Index nx, Index ny, double amount,
                           std::uint64_t seed = 1);

// Grid with square cells, as many along x as the length asks for.
TriangleMesh strip(double length, double width, Index cells_across,
                   const std::string& pattern = "alternating");
// Six sectors of concentric rings, 6 rings^2 triangles; vertex 0 is the centre.
TriangleMesh disc(double radius, Index rings);

TriangleMesh icosphere(double radius, int subdivisions);
TriangleMesh box(double x, double y, double z, Index cells_per_side = 1);
TriangleMesh capsule(double radius, double length,
                     Index segments = 32);  // axis z, length between cap centres
TriangleMesh cylinder(double radius, double length,
                      Index segments = 32);  // axis z; a prism, its corners on the cylinder
// Surface of revolution about z, closed with a wall of `wall` thickness: a cone from `top_radius`
// at z = height to `bottom_radius` at z = 0, then a tube of `tube_length` below.
TriangleMesh funnel(double top_radius, double bottom_radius, double height, double tube_length,
                    double wall, Index segments = 64);
// Thin wave-shaped bar: a tube of `radius` along y whose centre line waves in z.
TriangleMesh wave_bar(double length, double radius, double amplitude, double wavelength,
                      Index segments = 24);
TriangleMesh floor_square(double size, Index cells = 8);  // open square in z = 0, normal +z

}  // namespace loomstone
