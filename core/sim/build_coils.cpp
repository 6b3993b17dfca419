// Coils on bodies and obstacles, and bearings.
#include <cmath>

#include "core/magnetics/axisymmetric.h"
#include "core/sim/build.h"

namespace loomstone {

namespace {

void require(bool holds, const std::string& message) {
  if (!holds) throw InvalidInput(message);
}

void check_series(const Coil& coil, const std::vector<double>& values, const char* name, const std::string& where) {
  const bool constant = coil.times.empty() && values.size() <= 1;
  require(constant || coil.times.size() == values.size(),
          where + "." + name + " must have one value for each of the " + std::to_string(coil.times.size()) + " times, got " +
              std::to_string(values.size()));
  for (const double value : values) require(std::isfinite(value), where + "." + name + " must be finite");
  for (std::size_t i = 0; i < coil.times.size(); ++i)
    require(std::isfinite(coil.times[i]) && (i == 0 || coil.times[i] > coil.times[i - 1]),
            where + ".times must be finite and ascend [s]");
}

void check_coil(const Coil& coil, const std::string& where) {
  check_fields(coil, where);
  require(coil.shape == "loop" || coil.shape == "solenoid",
          where + ".shape must be loop or solenoid, got \"" + coil.shape + "\"");
  require((coil.shape == "solenoid") == (coil.length > 0.0),
          where + ".length must be > 0 [m] for a solenoid and left out for a loop");
  require(coil.position.allFinite() && coil.commutator.allFinite(), where + ".position and commutator must be finite");
  require(std::abs(coil.orientation.norm() - 1.0) < 1e-6, where + ".orientation must be a unit quaternion (w, x, y, z)");
  const bool circuit = coil.resistance > 0.0;
  require(circuit == coil.currents.empty(),
          where + " must have either currents, which are given, or a resistance > 0 [ohm], which makes a circuit");
  require(circuit || (coil.voltages.empty() && coil.inductance == 0.0 && coil.commutator.isZero(0.0)),
          where + ": voltages, inductance and commutator belong to a circuit; give a resistance, or leave them out");
  check_series(coil, circuit ? coil.voltages : coil.currents, circuit ? "voltages" : "currents", where);
}

void build_bearings(const Scene& scene, Model& model) {
  model.bearing_of_body.assign(scene.bodies.size(), -1);
  if (!scene.bearings.empty() && !scene.cloths.empty())
    throw Unsupported("scene.bearings hold bodies among bodies, not beside cloth; leave out the cloths or the bearings");
  for (std::size_t i = 0; i < scene.bearings.size(); ++i) {
    const Bearing& bearing = scene.bearings[i];
    const std::string where = "bearings[" + std::to_string(i) + "]";
    check_fields(bearing, where);
    const std::size_t body = find_by_name(scene.bodies, bearing.body, where + ".body");
    require(model.bearing_of_body[body] < 0, where + ".body has a bearing already; a body turns in one");
    require(bearing.axis.allFinite() && bearing.axis.norm() > 0.0, where + ".axis must be finite and not zero");
    const Vec3 axis = bearing.axis.normalized();
    const Mat3 inertia = world_inertia(model.body_mass[body], scene.bodies[body].orientation.normalized());
    const Vec3 momentum = inertia * axis;
    require((momentum - momentum.dot(axis) * axis).norm() <= 1e-3 * momentum.norm(),
            where + ".axis must be a principal axis of the body's inertia (within 1e-3); turn the body or balance it");
    model.bearing_of_body[body] = static_cast<int>(i);
  }
}

}  // namespace

void build_coils(const Scene& scene, Model& model) {
  build_bearings(scene, model);
  int circuits = 0;
  for (std::size_t i = 0; i < scene.coils.size(); ++i) {
    const Coil& coil = scene.coils[i];
    const std::string where = "coils[" + std::to_string(i) + "]";
    check_coil(coil, where);
    if (coil.resistance > 0.0 && ++circuits > 1)
      throw Unsupported(where + ": circuits do not act on one another; give all coils but one a current");
    const std::size_t carrier = find_carrier(scene, coil.body, where + ".body");
    Model::Wound wound;
    wound.carrier = static_cast<Index>(carrier);
    wound.local = {coil.position, coil.orientation.normalized()};
    if (carrier < scene.bodies.size()) wound.local.position -= model.body_mass[carrier].centre;
    if (coil.shape == "loop")
      wound.source = std::make_shared<Loop>(coil.radius, coil.turns);  // one ampere in every turn
    else
      wound.source = std::make_shared<Solenoid>(coil.radius, coil.length, coil.turns, 1.0);
    model.coils.push_back(std::move(wound));
  }
  if (scene.coils.empty()) return;
  for (const Magnet& magnet : scene.magnets)
    if (magnet.susceptibility != 0.0)
      throw Unsupported("coils act on hard magnets, not on bodies that magnetise; leave out magnets with a susceptibility");
}

}  // namespace loomstone
