// What the user asks for where currents act: coils on bodies and obstacles.
#pragma once

#include <string>
#include <vector>

#include "core/base/field.h"
#include "core/base/types.h"

namespace loomstone {

// Description. A winding about its z axis with a current that is given, or that of a circuit of
// resistance, inductance and source.
struct Coil {
  std::string body;
  std::string shape = "solenoid";
  double radius = 0.0, length = 0.0, turns = 1.0;
  Vec3 position = Vec3::Zero();
  Vec4 orientation = Vec4(1, 0, 0, 0);
  std::vector<double> times, currents, voltages;
  double resistance = 0.0, inductance = 0.0;
  Vec3 commutator = Vec3::Zero();

  static auto fields() {
    using C = Coil;
    return std::make_tuple(
        field("body", &C::body, "name of the rigid body or obstacle that carries it"),
        field("shape", &C::shape, "loop | solenoid (a sheet of current)"),
        field("radius", &C::radius, "m", positive(), "of the winding"),
        field("length", &C::length, "m", non_negative(), "of a solenoid"),
        field("turns", &C::turns, "1", positive(), "number of turns"),
        field("position", &C::position, "(3) of its middle in the frame of the body's mesh [m]"),
        field("orientation", &C::orientation,
              "unit quaternion (w, x, y, z), coil's axes to those of the body's mesh"),
        field("times", &C::times,
              "times of currents or voltages [s], ascending; empty: one value holds for ever"),
        field("currents", &C::currents,
              "given current at these times [A], linear between, counter-clockwise seen from +z"),
        field("voltages", &C::voltages,
              "of the source of a circuit at these times [V], linear between; empty: "
              "short-circuited"),
        field("resistance", &C::resistance, "ohm", non_negative(),
              "of a circuit, whose current follows L di/dt + R i = V - d(flux)/dt; 0: the current "
              "is given"),
        field("inductance", &C::inductance, "H", non_negative(),
              "of a circuit, of its winding in air"),
        field("commutator", &C::commutator,
              "(3) direction in space: the source is reversed while the coil's axis points against "
              "it; zero: none"));
  }
};

}  // namespace loomstone
