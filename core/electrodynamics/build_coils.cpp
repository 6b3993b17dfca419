// Builds and checks coils and bearings.
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "core/base/find_by_name.h"
#include "core/base/message.h"
#include "core/electrodynamics/build.h"
#include "core/electrodynamics/coil_currents.h"
#include "core/magnetics/induction/flux_linkage.h"
#include "core/magnetics/induction/mutual_inductance.h"

namespace loomstone {

namespace {

void check_series(const Coil& coil, const std::vector<double>& values, const char* name,
                  const std::string& where) {
  const bool constant = coil.times.empty() && values.size() <= 1;
  require(constant || coil.times.size() == values.size(),
          "{}.{} must have one value for each of the {} times, got {}", where, name,
          coil.times.size(), values.size());
  for (std::size_t i = 0; i < values.size(); ++i)
    require(std::isfinite(values[i]), "{}.{} must be finite, got {} at entry {}", where, name,
            values[i], i);
  for (std::size_t i = 0; i < coil.times.size(); ++i)
    require(std::isfinite(coil.times[i]) && (i == 0 || coil.times[i] > coil.times[i - 1]),
            "{}.times must be finite and ascending [s], got {} at entry {}; sort them", where,
            coil.times[i], i);
}

void check_winding(const Coil& coil, const std::string& where) {
  std::optional<CircularWinding> winding;
  if (coil.source) winding = coil.source->source->winding();
  if (!winding)
    fail<InvalidInput>("{}.source must be a loop or a solenoid of loomstone.magnetics, got {}",
                       where, coil.source ? "another source" : "none");
  const double current = winding->turn_current;
  require(current == 1.0,
          "{}.source must have its default current of 1 A, got {} A; give the current as currents",
          where, current);
}

void check_coil(const Coil& coil, const std::string& where) {
  check_fields(coil, where);
  require(coil.commutator.allFinite(), "{}.commutator must be finite", where);
  const bool circuit = coil.resistance > 0.0;
  require(circuit == coil.currents.empty(),
          "{} must have either currents (prescribed) or a resistance > 0 [ohm] (a circuit), got {}",
          where, circuit ? "both" : "neither");
  require(
      circuit || (coil.voltages.empty() && coil.inductance == 0.0 && coil.commutator.isZero(0.0)),
      "{}: voltages, inductance and commutator belong to a circuit; give a resistance, or leave "
      "them out",
      where);
  check_series(coil, circuit ? coil.voltages : coil.currents, circuit ? "voltages" : "currents",
               where);
}

// Checks the requirements of a circuit in a scene with magnetisable bodies. The bodies must respond
// linearly (without saturation) and also to each other's fields (no explicit response), and the
// circuit must have a self-inductance.
void check_circuit(const Coil& coil, const MagneticModel& model, const std::string& where) {
  for (std::size_t k = 0; k < model.magnets.size(); ++k) {
    const CarriedMagnet& magnet = model.magnets[k];
    if (magnet.source) continue;
    if (magnet.saturation > 0.0 || magnet.cells.rows() > 0)
      fail<Unsupported>(
          "{}: with a circuit, bodies must magnetise linearly and mutually, got magnets[{}] with "
          "{}; leave that out, or prescribe the currents of the coil",
          where, k, magnet.saturation > 0.0 ? "saturation" : "the explicit response");
    require(coil.inductance > 0.0,
            "{}.inductance must be > 0 [H] together with bodies that magnetise, got {}; give that "
            "of the winding in air",
            where, coil.inductance);
  }
}

// Throws InvalidInput, because the matrix `inductances` (circuits x circuits) [H] is not positive
// definite. The message states the inductances of the two most strongly coupled circuits.
[[noreturn]] void refuse_inductances(const MagneticModel& model,
                                     const Eigen::MatrixXd& inductances) {
  Eigen::Index one = 0, other = 1;
  double strongest = -1.0;
  for (Eigen::Index b = 1; b < inductances.rows(); ++b)
    for (Eigen::Index a = 0; a < b; ++a) {
      const double product = inductances(a, a) * inductances(b, b);
      const double coupling = product > 0.0 ? inductances(a, b) * inductances(a, b) / product
                                            : std::numeric_limits<double>::infinity();
      if (coupling > strongest) strongest = coupling, one = a, other = b;
    }
  fail<InvalidInput>(
      "circuits must have a positive definite matrix of inductances (M^2 < L_1 L_2 for each pair), "
      "got M = {:.6g} H, L_1 = {:.6g} H and L_2 = {:.6g} H for coils[{}] and coils[{}]; give each "
      "coil the inductance of its winding",
      inductances(one, other), inductances(one, one), inductances(other, other),
      model.circuits[one], model.circuits[other]);
}

// Checks that the winding of coil j does not enter magnet k, which is a magnetisable body. If the
// scene has circuits and the flux of the body through the coil matters (CarriedCoil::wants_flux()),
// also checks that the body does not lie both in the bore and outside the winding. The second check
// is omitted for a sphere treated as a point dipole.
void check_apart(const MagneticModel& model, const CarrierPlaces& start, std::size_t j,
                 std::size_t k) {
  const CarriedCoil& wound = model.coils[j];
  const CarriedMagnet& magnet = model.magnets[k];
  const MagneticBody coil{wound.source, start.pose(wound.carrier, wound.local)};
  const RigidPose place = start.pose(magnet.carrier, magnet.local);
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
      require((solid ? solid->depth(there) : radius - there.norm()) <= 1e-6 * radius,
              "coils[{}] must lie apart from bodies that magnetise, got a winding that enters "
              "magnets[{}]; move one of them",
              j, k);
    }
  if (!solid || model.circuits.empty() || !wound.wants_flux()) return;
  const BesideWinding beside = beside_winding(coil, {solid, place});
  if (beside.in_bore && beside.outside)
    fail<Unsupported>(
        "coils[{}]: a body that magnetises must lie in the bore of a circuit's winding or outside "
        "it, got magnets[{}], which reaches around it; split the body",
        j, k);
}

}  // namespace

void add_bearings(const MagneticScene& scene, MagneticModel& model) {
  const std::span bodies(scene.carriers.data(), static_cast<std::size_t>(scene.n_bodies));
  for (std::size_t i = 0; i < scene.bearings.size(); ++i) {
    const Bearing& bearing = scene.bearings[i];
    const std::string where = formatted("bearings[{}]", i);
    check_fields(bearing, where);
    const std::size_t body = find_by_name(bodies, bearing.body, where + ".body");
    require(!model.bodies[body].bearing,
            "{}.body must have one bearing, but \"{}\" has a bearing already; remove one", where,
            bearing.body);
    require(bearing.axis.allFinite() && bearing.axis.norm() > 0.0,
            "{}.axis must be finite and not zero", where);
    const Vec3 axis = bearing.axis.normalized();
    const Mat3 inertia = world_inertia(bodies[body].mass, bodies[body].orientation.normalized());
    const Vec3 momentum = inertia * axis;
    const double deviation = (momentum - momentum.dot(axis) * axis).norm() / momentum.norm();
    require(deviation <= 1e-3,
            "{}.axis must be a principal axis of the body's inertia (within 1e-3), got one that "
            "deviates by {:.3g}; turn the body or balance it",
            where, deviation);
    model.bodies[body].bearing = bearing;
    model.bodies[body].bearing->axis = axis;
  }
}

void add_coils(const MagneticScene& scene, MagneticModel& model) {
  for (std::size_t i = 0; i < scene.coils.size(); ++i) {
    const Coil& coil = scene.coils[i];
    const std::string where = formatted("coils[{}]", i);
    check_coil(coil, where);
    check_winding(coil, where);
    const bool circuit = coil.resistance > 0.0;
    if (circuit && scene.n_bodies == 0)
      fail<Unsupported>(
          "{}: circuits are advanced together with rigid bodies, but the scene has none; add a "
          "body anywhere",
          where);
    const Stand stand = find_stand(scene, coil.body, coil.source->pose, where + ".body");
    model.coils.push_back({coil, coil.source->source, stand.local, stand.carrier});
    (circuit ? model.circuits : model.given).push_back(i);
  }
  for (const std::size_t i : model.circuits)
    check_circuit(scene.coils[i], model, formatted("coils[{}]", i));
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
  if (m >= 2 && inductances.llt().info() != Eigen::Success) refuse_inductances(model, inductances);
}

}  // namespace loomstone
