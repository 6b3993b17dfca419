// Panels: pieces of a source's surface charge or current, parametrised over the unit square for the
// quadrature of another source's field.
#pragma once

#include "core/base/types.h"

namespace loomstone {

// The force on a magnetic charge q [A m] is q mu0 H, on a current element I dl [A m] it is I dl x
// B.
struct PanelSample {
  Vec3 position = Vec3::Zero();  // [m]
  Vec3 area = Vec3::Zero();      // outward normal times area of the face it stands for [m^2]
  double charge = 0.0;           // [A m]
  Vec3 current = Vec3::Zero();   // [A m]
};

struct Panel {
  enum class Shape { parallelogram, triangle, segment, side, disc, circle };
  Shape shape;
  Vec3 a = Vec3::Zero(), b = Vec3::Zero(),
       c = Vec3::Zero();  // a corner and the two edges from it
  double radius0 = 0.0,
         radius1 = 0.0;  // inner and outer radius of a disc; side and circle use radius1 [m]
  double azimuth = 0.0, turn = 0.0;     // first azimuth, angle covered [rad]
  double height0 = 0.0, height1 = 0.0;  // along z [m]
  Vec3 magnetization = Vec3::Zero();    // [A/m]; charge density is its normal component
  double sign = 1.0;                    // of the outward normal: -1 on bores and lower faces
  double current = 0.0;                 // [A], on a side [A/m], along growing azimuth

  bool line() const { return shape == Shape::segment || shape == Shape::circle; }
  // Sample at (u, v) in the unit square (lines ignore v); area, charge and current are per unit of
  // u and v.
  PanelSample at(double u, double v) const;
};

}  // namespace loomstone
