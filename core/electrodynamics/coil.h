// Description of a coil in a scene, on a body or obstacle.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/field.h"
#include "core/magnetics/sources/body.h"

namespace loomstone {

// A winding. Its current is either given or that of a circuit with a resistance, an inductance and
// a voltage source.
struct Coil {
  std::string body;
  std::optional<MagneticBody> source;
  std::vector<double> times, currents, voltages;
  double resistance = 0.0, inductance = 0.0;
  Vec3 commutator = Vec3::Zero();

  static auto fields() {
    using C = Coil;
    return std::make_tuple(
        field("body", &C::body, "name of the rigid body or obstacle that carries it"),
        field("source", &C::source,
              "winding: loop or solenoid of loomstone.magnetics, made with 1 A, at its pose in the "
              "frame of the body's mesh"),
        field("times", &C::times,
              "times of currents or voltages [s], ascending; empty: one constant value"),
        field("currents", &C::currents,
              "prescribed current per turn at these times [A], linearly interpolated, "
              "counter-clockwise seen from +z of the winding"),
        field("voltages", &C::voltages,
              "source voltage of a circuit at these times [V], linearly interpolated; empty: "
              "short-circuited"),
        field("resistance", &C::resistance, "ohm", non_negative(),
              "resistance R of a circuit, L di/dt + R i = V - d(flux)/dt; 0: prescribed current"),
        field("inductance", &C::inductance, "H", non_negative(),
              "inductance L of a circuit: that of its winding in air; 0: the current follows the "
              "voltage at once"),
        field("commutator", &C::commutator,
              "(3) commutator direction in space: the source voltage is reversed while the coil's "
              "axis points against it; zero: no commutator"));
  }
};

}  // namespace loomstone
