// Builds and checks coils and bearings.
#include <algorithm>
#include <cmath>
#include <span>

#include "core/base/find_by_name.h"
#include "core/electrodynamics/build.h"
#include "core/electrodynamics/coil_currents.h"
#include "core/magnetics/induction/flux_linkage.h"
#include "core/magnetics/induction/mutual_inductance.h"

namespace loomstone {

namespace {

void require(bool holds, const std::string& message) {
  if (!holds) throw InvalidInput(message);
}

void check_series(const Coil& coil, const std::vector<double>& values, const char* name,
                  const std::string& where) {
  const bool constant = coil.times.empty() && values.size() <= 1;
  require(constant || coil.times.size() == values.size(),
          where + "." + name + " must have one value for each of the " +
              std::to_string(coil.times.size()) + " times, got " + std::to_string(values.size()));
  for (const double value : values)
    require(std::isfinite(value), where + "." + name + " must be finite");
  for (std::size_t i = 0; i < coil.times.size(); ++i)
    require(std::isfinite(coil.times[i]) && (i == 0 || coil.times[i] > coil.times[i - 1]),
            where + ".times must be finite and ascend [s]");
}

void check_winding(const Coil& coil, const std::string& where) {
  std::optional<CircularWinding> winding;
  if (coil.source) winding = coil.source->source->winding();
  if (!winding)
    throw InvalidInput(where + ".source must be a loop or a solenoid of loomstone.magnetics, got " +
                       (coil.source ? "another one" : "none"));
  const double current = winding->turn_current;
  require(current == 1.0,
          where + ".source must be made with the current of 1 A that it has by default, got " +
              std::to_string(current) + " A; give that as currents");
}

void check_coil(const Coil& coil, const std::string& where) {
  check_fields(coil, where);
  require(coil.commutator.allFinite(), where + ".commutator must be finite");
  const bool circuit = coil.resistance > 0.0;
  require(circuit == coil.currents.empty(), where +
                                                " must have either currents, which are given, or a "
                                                "resistance > 0 [ohm], which makes a circuit");
  require(
      circuit || (coil.voltages.empty() && coil.inductance == 0.0 && coil.commutator.isZero(0.0)),
      where +
          ": voltages, inductance and commutator belong to a circuit; give a resistance, or leave "
          "them out");
  check_series(coil, circuit ? coil.voltages : coil.currents, circuit ? "voltages" : "currents",
               where);
}

// Checks that magnetisable bodies respond linearly and mutually, as circuits require. Also checks
// that a circuit has a self-inductance if there are such bodies.
void check_circuit(const Coil& coil, const MagneticModel& model, const std::string& where) {
  for (const CarriedMagnet& magnet : model.magnets) {
    if (magnet.source) continue;
    if (magnet.saturation > 0.0 || magnet.cells.rows() > 0)
      throw Unsupported(
          where +
          ": circuits want bodies that magnetise to do so linearly and mutually, got one with " +
          (magnet.saturation > 0.0 ? "saturation" : "the explicit response") +
          "; leave that out, or give the coil a current");
    require(coil.inductance > 0.0, where +
                                       ".inductance must be > 0 [H] beside bodies that "
                                       "magnetise; give it that of the winding in air");
  }
}

// Checks that a winding does not enter a magnetisable body, and that no such body reaches around
// the winding of a circuit.
void check_apart(const MagneticModel& model, const CarrierPlaces& start, std::size_t j,
                 std::size_t k) {
  const CarriedCoil& wound = model.coils[j];
  const CarriedMagnet& magnet = model.magnets[k];
  const MagneticBody coil{wound.source, start.pose(wound.carrier, wound.local)};
  const RigidPose place = start.pose(magnet.carrier, magnet.local);
  const std::string where = "coils[" + std::to_string(j) + "]";
  const SourcePtr solid =
      magnet.soft ? magnet.soft->solid() : nullptr;  // null: a sphere treated as a point dipole
  const double radius = solid ? solid->radius() : magnet.radius;
  const RigidPose pose = relative_pose(coil.pose, place);
  const Mat3 rotation = rotation_matrix(pose.orientation);
  for (const Panel& panel : wound.source->panels())
    for (int i = 0; i < 64; ++i) {
      const int row = i / 8, column = i % 8;
      const Vec3 point = panel.at(column / 7.0, panel.line() ? 0.0 : row / 7.0).position;
      const Vec3 there = pose.position + rotation * point;
      require(
          (solid ? solid->depth(there) : radius - there.norm()) <= 1e-6 * radius,
          where + " must lie apart from bodies that magnetise, got a winding that goes into one");
    }
  if (!solid || model.circuits.empty() || !wound.wants_flux()) return;
  const BesideWinding beside = beside_winding(coil, {solid, place});
  if (beside.in_bore && beside.outside)
    throw Unsupported(where +
                      ": circuits want bodies that magnetise in the bore or beside the "
                      "winding, got magnets[" +
                      std::to_string(k) + "], which reaches round it; split the body");
}

}  // namespace

void add_bearings(const MagneticScene& scene, MagneticModel& model) {
  const std::span bodies(scene.carriers.data(), static_cast<std::size_t>(scene.n_bodies));
  for (std::size_t i = 0; i < scene.bearings.size(); ++i) {
    const Bearing& bearing = scene.bearings[i];
    const std::string where = "bearings[" + std::to_string(i) + "]";
    check_fields(bearing, where);
    const std::size_t body = find_by_name(bodies, bearing.body, where + ".body");
    require(!model.bodies[body].bearing,
            where + ".body has a bearing already; a body turns in one");
    require(bearing.axis.allFinite() && bearing.axis.norm() > 0.0,
            where + ".axis must be finite and not zero");
    const Vec3 axis = bearing.axis.normalized();
    const Mat3 inertia = world_inertia(bodies[body].mass, bodies[body].orientation.normalized());
    const Vec3 momentum = inertia * axis;
    require((momentum - momentum.dot(axis) * axis).norm() <= 1e-3 * momentum.norm(),
            where +
                ".axis must be a principal axis of the body's inertia (within 1e-3); turn the body "
                "or balance it");
    model.bodies[body].bearing = bearing;
    model.bodies[body].bearing->axis = axis;
  }
}

void add_coils(const MagneticScene& scene, MagneticModel& model) {
  for (std::size_t i = 0; i < scene.coils.size(); ++i) {
    const Coil& coil = scene.coils[i];
    const std::string where = "coils[" + std::to_string(i) + "]";
    check_coil(coil, where);
    check_winding(coil, where);
    const bool circuit = coil.resistance > 0.0;
    if (circuit && scene.n_bodies == 0)
      throw Unsupported(where +
                        ": circuits are advanced together with rigid bodies, got a scene without "
                        "one; add a body anywhere");
    const Stand stand = find_stand(scene, coil.body, coil.source->pose, where + ".body");
    model.coils.push_back({coil, coil.source->source, stand.local, stand.carrier});
    (circuit ? model.circuits : model.given).push_back(i);
  }
  for (const std::size_t i : model.circuits)
    check_circuit(scene.coils[i], model, "coils[" + std::to_string(i) + "]");
}

void check_coils(const MagneticModel& model, const CarrierPlaces& start) {
  std::vector<MagneticBody> coils = placed_coils(model, start);
  for (std::size_t j = 0; j < coils.size(); ++j)
    for (std::size_t k = 0; k < model.magnets.size(); ++k)
      if (!model.magnets[k].source) check_apart(model, start, j, k);
  const auto m = static_cast<Eigen::Index>(model.circuits.size());
  Eigen::MatrixXd inductances(m, m);
  for (Eigen::Index a = 0; a < m; ++a) {
    inductances(a, a) = model.coils[model.circuits[a]].coil.inductance;
    for (Eigen::Index b = 0; b < a; ++b)
      inductances(a, b) = inductances(b, a) =
          mutual_inductance(coils[model.circuits[b]], coils[model.circuits[a]], 1e-4);
  }
  if (m < 2) return;
  require(inductances.llt().info() == Eigen::Success,
          "circuits must have inductances [H] whose mutual ones M keep M^2 < L_1 L_2, got M = " +
              std::to_string(inductances(1, 0)) +
              " H of the first two; give them the inductance of their winding");
}

}  // namespace loomstone
