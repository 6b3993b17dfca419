// Description of a magnet in a scene, on a body or obstacle.
#pragma once

#include <string>
#include <variant>

#include "core/base/field.h"
#include "core/magnetics/induction/linear_magnetization.h"
#include "core/magnetics/sources/body.h"

namespace loomstone {

// A permanent magnet, or a body that is magnetised by the field in which it lies. std::monostate
// means that no source is given, which is an error.
using MagnetSource = std::variant<std::monostate, MagneticBody, SoftBody>;

// A magnet, or a body that magnetises, on a rigid body or obstacle. One rigid body or obstacle may
// carry several magnets.
struct Magnet {
  std::string body;  // name of the rigid body or obstacle that carries it
  MagnetSource source;
  std::string response = "mutual";
  double density = 0.0;

  static auto fields() {
    using M = Magnet;
    return std::make_tuple(
        field("body", &M::body, "name of the rigid body or obstacle that carries it"),
        field("source", &M::source,
              "magnet (cuboid, cylinder, sphere, mesh, dipoles or cells of loomstone.magnetics) or "
              "body that magnetises (soft_cuboid, soft_cylinder, soft_sphere, soft_mesh), at its "
              "pose in the frame of the body's mesh"),
        field("response", &M::response,
              "response of a body that magnetises: mutual (to the field of all other sources) | "
              "explicit (as in Thomaszewski 2010: cells of `density` respond as isolated "
              "spheres, but not to each other or to other bodies that magnetise)"),
        field("density", &M::density, "1/m^3", non_negative(),
              "number density of the cells of an explicit response"));
  }
};

}  // namespace loomstone
