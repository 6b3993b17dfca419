// What the user asks for where bodies and obstacles are magnetic.
#pragma once

#include <limits>
#include <memory>
#include <string>

#include "core/base/field.h"
#include "core/base/types.h"
#include "core/mesh/triangle_mesh.h"

namespace loomstone {

// Description. What makes a rigid body or an obstacle magnetic; one that carries several has one of
// these for each.
struct Magnet {
  std::string body;  // name of the rigid body or obstacle that carries it
  std::string shape = "mesh";
  std::shared_ptr<const TriangleMesh> mesh;
  Vec3 size = Vec3::Zero();
  double radius = 0.0, inner_radius = 0.0, height = 0.0;
  Vec3 position = Vec3::Zero();
  Vec4 orientation = Vec4(1, 0, 0, 0);
  Vec3 polarization = Vec3::Zero();
  Vec3 moment = Vec3::Zero();
  double susceptibility = 0.0;
  double saturation = 0.0;
  int resolution = 0;
  double focus = 0.0;
  std::string response = "mutual";
  std::string engine = "accurate";
  double density = 0.0;

  static auto fields() {
    using M = Magnet;
    return std::make_tuple(
        field("body", &M::body, "name of the rigid body or obstacle that carries it"),
        field("shape", &M::shape, "mesh | sphere | cuboid | cylinder (about its z axis) | dipole"),
        field("mesh", &M::mesh,
              "closed surface in the magnet's own frame, of shape mesh; none: that of the body"),
        field("size", &M::size, "(3) edges of a cuboid [m]"),
        field("radius", &M::radius, "m", non_negative(), "of a sphere or cylinder"),
        field("inner_radius", &M::inner_radius, "m", non_negative(), "of a cylinder with a bore"),
        field("height", &M::height, "m", non_negative(), "of a cylinder"),
        field("position", &M::position,
              "(3) of the magnet's origin in the frame of the body's mesh [m]"),
        field("orientation", &M::orientation,
              "unit quaternion (w, x, y, z), magnet's axes to those of the body's mesh"),
        field("polarization", &M::polarization,
              "(3) J = mu0 M in the magnet's axes, fixed to it [T]; not of a dipole"),
        field("moment", &M::moment, "(3) of a dipole in the magnet's axes [A m^2]"),
        field("susceptibility", &M::susceptibility, "1",
              Limits{-1.0, std::numeric_limits<double>::infinity(), false, true},
              "chi of a sphere, cuboid, cylinder or mesh that magnetises in the field it is in, "
              "instead of a polarization: > 0 soft iron, < 0 diamagnetic, -1 superconducting"),
        field("saturation", &M::saturation, "T", non_negative(),
              "mu0 M_s with a susceptibility > 0, followed in the means over the body; 0: none"),
        field("resolution", &M::resolution, "1", between(0, 8000),
              "with a susceptibility: degree of the harmonics of a sphere (1: a point dipole), "
              "cells along each edge of a cuboid (a multiple of 4 from 8 to 48) or the side of a "
              "cylinder (from 8 to 24), least number of panels of a mesh; 0: 1, 8 or 500"),
        field("focus", &M::focus, "m", non_negative(),
              "of a cuboid with a susceptibility: half the width of what is near the middle of its "
              "wide faces, where panels are finer then; 0: none"),
        field(
            "response", &M::response,
            "with a susceptibility: mutual, to the field of all others | explicit, the thesis' own "
            "way: cells of `density` that answer as lone spheres, to permanent magnets alone"),
        field("engine", &M::engine,
              "accurate: exact fields, forces to magnetic_tolerance | cells: dipole cells, fast "
              "and rough"),
        field("density", &M::density, "1/m^3", non_negative(),
              "of cells, where engine is cells or response is explicit"));
  }
};

}  // namespace loomstone
