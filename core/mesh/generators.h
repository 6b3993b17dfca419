// Generated meshes. Flat cloth lies in z = 0, centred at the origin, weft along x, with its
// coordinates as uv. Closed surfaces are centred, except the funnel, and oriented outward. All
// lengths in [m].
#pragma once

#include <cstdint>
#include <string>

#include "core/mesh/triangle_mesh.h"

namespace loomstone {

// Rectangle of nx x ny cells with two triangles each; vertex j (nx + 1) + i is at column i, row j.
// pattern: "alternating" (diagonals alternate like a checkerboard) | "diagonal" (all along +45
// degrees).
TriangleMesh grid_cells(double width, double height, Index nx, Index ny,
                        const std::string& pattern = "alternating");
// Grid with nearly square cells and nearly as many triangles as requested.
TriangleMesh grid(double width, double height, Index triangles,
                  const std::string& pattern = "alternating");
// Grid with interior vertices displaced at random (seeded) by up to `amount` of a cell: irregular
// but valid. The Python package makes better unstructured meshes (Delaunay of relaxed points).
TriangleMesh jittered_grid(double width, double height, Index nx, Index ny, double amount,
                           std::uint64_t seed = 1);

// Grid with `cells_across` square cells across its width.
TriangleMesh strip(double length, double width, Index cells_across,
                   const std::string& pattern = "alternating");
// Six sectors of concentric rings, 6 rings^2 triangles; vertex 0 is the centre.
TriangleMesh disc(double radius, Index rings);

TriangleMesh icosphere(double radius, int subdivisions);
TriangleMesh box(double x, double y, double z, Index cells_per_side = 1);
// Axis z; `length` between the centres of the caps.
TriangleMesh capsule(double radius, double length, Index segments = 32);
// Axis z; a prism with its corners on the cylinder.
TriangleMesh cylinder(double radius, double length, Index segments = 32);
// Surface of revolution about z, closed with a wall of `wall` thickness: a cone from `top_radius`
// at z = height to `bottom_radius` at z = 0, then a tube of `tube_length` below.
TriangleMesh funnel(double top_radius, double bottom_radius, double height, double tube_length,
                    double wall, Index segments = 64);
// Thin wave-shaped bar: a tube of `radius` along y with a sinusoidal centre line in z.
TriangleMesh wave_bar(double length, double radius, double amplitude, double wavelength,
                      Index segments = 24);
TriangleMesh floor_square(double size, Index cells = 8);  // open square in z = 0, normal +z

}  // namespace loomstone
