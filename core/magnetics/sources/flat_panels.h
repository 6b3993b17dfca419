// Flat panels that approximate the surfaces of bodies for the boundary element method (graded grids
// on cuboids and cylinders, and triangles of meshes), and quadrature points on these panels.
#pragma once

#include <vector>

#include "core/magnetics/sources/panel.h"

namespace loomstone {

class TriangleMesh;

struct FlatPanel {
  int corners = 3;  // 3, or 4 for a rectangle
  Vec3 corner[4];   // counter-clockwise seen from outside [m]
  Vec3 normal, centre;
  double area = 0.0, reach = 0.0;  // area [m^2], largest distance of a corner from the centre [m]

  // Returns the point of the panel that corresponds to (u, v) in the unit square. On a triangle,
  // the side u = 0 collapses to corner 0.
  Vec3 at(double u, double v) const;
};

FlatPanel make_panel(const Vec3* corners, int n);

struct PanelPoint {
  Vec3 position;
  double share = 0.0;  // fraction of the panel's area that the point represents
};
// Returns the points of the tensor-product Gauss rule with `order` points in each direction. On a
// triangle, one side of the unit square collapses to corner 0.
std::vector<PanelPoint> panel_points(const FlatPanel& panel, int order);

// Returns the panels of a cuboid centred at the origin, with `cells` (even) panels along its
// shortest edges. Panels are refined quadratically towards edges and corners, where the charge is
// singular. The number of panels along a longer edge is a multiple of `cells`. If `cells` is large,
// panels far from the ends of an edge are at most 1.38 times as wide as those in the middle of the
// shortest edge. This width resolves the charge that a nearby magnet induces opposite the magnet's
// edges: in a thin body, this charge varies at the scale of the thickness. Very wide bodies have
// fewer panels than this width requires, and the size of their panels grows towards the middle.
//
// If focus > 0 [m], all edges have `cells` panels, which are also refined in the middle of wide
// faces, for a magnet near this middle. Closer to the middle than `focus`, panels are nearly equal
// in size. Farther out, their size grows with the distance, until they are refined towards the
// edges.
//
// The first n/8 of the n panels lie in the octant x, y, z > 0. For s = 1 ... 7, panel s n/8 + i is
// panel i mirrored along the axes whose bits are set in s (1: x, 2: y, 4: z).
std::vector<FlatPanel> cuboid_panels(const Vec3& size, int cells, double focus);

// Returns the triangles of a cylinder |z| <= height / 2 about the origin, or of a ring if
// inner_radius > 0. The surface is a prism with 2 * cells sides and the cross-sectional area of the
// cylinder. It has `cells` (even) rows along its side, or more if it is slender, and cells / 2 rows
// along a radius or across the wall. Rows are refined towards the rims, where the charge is
// singular.
std::vector<FlatPanel> cylinder_panels(double radius, double inner_radius, double height,
                                       int cells);

// Returns the triangles of a closed mesh, refined until there are at least `panels` of them. Each
// refinement bisects the longest edge, and thereby the two triangles at this edge.
std::vector<FlatPanel> mesh_panels(const TriangleMesh& mesh, Index panels);

}  // namespace loomstone
