// Description of a coil on a body or obstacle.
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
              "times of currents or voltages [s], ascending; empty: one value holds for ever"),
        field("currents", &C::currents,
              "given current in each turn at these times [A], linear between, counter-clockwise "
              "seen from +z of the winding"),
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
