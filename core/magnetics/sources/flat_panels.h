// Surfaces of bodies as flat panels with quadrature points, for the boundary element method: graded
// grids on the faces of cuboids and cylinders, and triangles of meshes.
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
          double v) const;  // (u, v) in the unit square, which folds onto corner 0 of a triangle
};

FlatPanel make_panel(const Vec3* corners, int n);

struct PanelPoint {
  Vec3 position;
  double share = 0.0;  // of the panel's area
};
// Tensor Gauss rule with `order` points in each direction; on triangles it is folded into a corner.
std::vector<PanelPoint> panel_points(const FlatPanel& panel, int order);

// Panels of a cuboid about the origin, refined quadratically towards edges and corners, where the
// charge is singular: `cells` (even) along every edge. focus > 0 [m] refines the middle of wide
// faces as well, for magnets close to it: panels are nearly equal within that distance of the
// middle and grow in proportion to the distance beyond. The first eighth of the panels lies in the
// octant x, y, z > 0, and panel s n/8 + i is the mirror image of panel i along the axes of the bits
// of s.
std::vector<FlatPanel> cuboid_panels(const Vec3& size, int cells, double focus);

// Triangles of a cylinder |z| <= height / 2 about the origin or, with inner_radius > 0, of a ring:
// a prism with 2 `cells` sides and the cross-sectional area of the cylinder. There are `cells`
// (even) rows along its side (more on slender cylinders) and cells / 2 along a radius or across the
// wall, refined towards the rims, where the charge is singular.
std::vector<FlatPanel> cylinder_panels(double radius, double inner_radius, double height,
                                       int cells);

// Triangles of a mesh after bisecting the longest edges, with both triangles of each, until there
// are at least `panels`.
std::vector<FlatPanel> mesh_panels(const TriangleMesh& mesh, Index panels);

}  // namespace loomstone
