// Pieces of the charge or current of a source, over which another source's field is integrated.
#pragma once

#include "core/base/types.h"

namespace loomstone {

// A charge [A m] feels charge * mu0 H; an element of current [A m] feels current x B.
struct PanelSample {
  Vec3 position = Vec3::Zero();  // [m]
  Vec3 area = Vec3::Zero();      // outward normal times area, of faces [m^2]
  double charge = 0.0;           // [A m]
  Vec3 current = Vec3::Zero();   // [A m]
};

struct Panel {
  enum class Shape { parallelogram, triangle, segment, side, disc, circle };
  Shape shape;
  Vec3 a = Vec3::Zero(), b = Vec3::Zero(),
       c = Vec3::Zero();  // corner and two edges; of a triangle the corner's neighbour edges
  double radius0 = 0.0,
         radius1 = 0.0;  // of side and circle: radius1; of a disc its inner and outer radius [m]
  double azimuth = 0.0, turn = 0.0;     // first azimuth and how far it goes [rad]
  double height0 = 0.0, height1 = 0.0;  // along z [m]
  Vec3 magnetization = Vec3::Zero();    // [A/m], charge is its component along the normal
  double sign = 1.0;                    // of the normal: -1 on bores and lower faces
  double current = 0.0;                 // [A], on a side [A/m], towards growing azimuth

  bool line() const { return shape == Shape::segment || shape == Shape::circle; }
  // At (u, v) in the unit square (v is ignored on lines), area, charge and current times
  // d(position)/d(u, v).
  PanelSample at(double u, double v) const;
};

}  // namespace loomstone
