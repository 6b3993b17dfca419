// Panels divide the surface or wire of a source. They can carry charge or current, and they are
// parametrised over the unit square for quadrature of forces in the field of another source.
#pragma once

#include "core/base/types.h"

namespace loomstone {

// Quadrature point of a surface or wire, with its charge and current. A magnetic charge q [A m]
// experiences the force q mu0 H, and a current element I dl [A m] experiences the force I dl x B.
struct PanelSample {
  Vec3 position = Vec3::Zero();  // [m]
  Vec3 area = Vec3::Zero();      // outward normal times the area that the sample represents [m^2]
  double charge = 0.0;           // [A m]
  Vec3 current = Vec3::Zero();   // [A m]
};

struct Panel {
  enum class Shape { parallelogram, triangle, segment, side, disc, circle };
  Shape shape;
  Vec3 a = Vec3::Zero(), b = Vec3::Zero(),
       c = Vec3::Zero();  // first corner and the two edges from it [m]; a segment has only edge b
  double radius0 = 0.0,
         radius1 = 0.0;  // inner and outer radius of a disc [m]; sides and circles use radius1
  double azimuth = 0.0, turn = 0.0;     // first azimuth and angle covered [rad]
  double height0 = 0.0, height1 = 0.0;  // range of a side along z [m]; a disc is at height0
  // If positive, the inner or outer boundary of a disc is the circle of this radius about `a` [m]
  // instead of the circle of radius0 or radius1. The circle must surround the z axis.
  double circle0 = 0.0, circle1 = 0.0;
  // If not zero, the inner or outer boundary of a disc is a straight line instead. The line is
  // given by its point nearest to the z axis [m], with z set to 0.
  Vec3 line0 = Vec3::Zero(), line1 = Vec3::Zero();
  Vec3 magnetization = Vec3::Zero();  // [A/m]; its normal component is the charge density
  // Sign of the outward normal, along the radius on a side or along z on a disc (-1: bore, lower
  // face).
  double sign = 1.0;
  // Current of a segment or circle [A], or current per height of a cylinder's side [A/m]. A
  // positive current flows along b on segments, and towards larger azimuth on circles and sides.
  double current = 0.0;

  bool line() const { return shape == Shape::segment || shape == Shape::circle; }
  // Returns the distance [m] from the z axis to the inner (0) or outer (1) boundary of a disc, in
  // the direction (cosine, sine).
  double reach(int boundary, double cosine, double sine) const;
  // Returns the sample at (u, v) in the unit square; segments and circles ignore v. Area, charge
  // and current are densities with respect to u and v.
  PanelSample at(double u, double v) const;
};

}  // namespace loomstone
