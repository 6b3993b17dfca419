// Surfaces of bodies as flat panels with points of quadrature: graded grids on the faces of cuboids
// and cylinders, triangles of meshes.
#pragma once

#include <vector>

#include "core/magnetics/sources/panel.h"

namespace loomstone {

class TriangleMesh;

struct FlatPanel {
  int corners = 3;  // 3 or 4 (rectangle)
  Vec3 corner[4];   // counter-clockwise seen from outside [m]
  Vec3 normal, centre;
  double area = 0.0, reach = 0.0;  // [m^2], from the centre to the farthest corner [m]

  Vec3 at(double u,
          double v) const;  // of a rectangle, (u, v) in the unit square; of a triangle u >= v in it
};

FlatPanel make_panel(const Vec3* corners, int n);

struct PanelPoint {
  Vec3 position;
  double share = 0.0;  // of the panel's area
};
// Points of a Gauss rule with `order` points a direction, on triangles folded into a corner.
std::vector<PanelPoint> panel_points(const FlatPanel& panel, int order);

// Panels of a cuboid about the origin whose charge is singular at edges and corners: cells (even)
// along every edge, whose distance from the nearest end grows with the square of their number.
// focus > 0 [m]: besides, they are nearly equal within so far of the middle and grow with the
// distance from it beyond, for what is near the middle of a wide face. The first eighth of them
// lies where x, y, z > 0; the others are its mirror images: panel s n/8 + i is panel i mirrored
// along the axes of the bits of s.
std::vector<FlatPanel> cuboid_panels(const Vec3& size, int cells, double focus);

// Triangles of a cylinder |z| <= height / 2 about the origin or, with inner_radius > 0, of a ring;
// a prism of 2 cells sides with the cross section of the cylinder. cells (even) along its side,
// some more of a long one, half of them along a radius or across the wall, finer towards the rims,
// where the charge is singular.
std::vector<FlatPanel> cylinder_panels(double radius, double inner_radius, double height,
                                       int cells);

// Triangles of a mesh, the longest edges bisected (neighbours with them) until there are at least
// `panels`.
std::vector<FlatPanel> mesh_panels(const TriangleMesh& mesh, Index panels);

}  // namespace loomstone
