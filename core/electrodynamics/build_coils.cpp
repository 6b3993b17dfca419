// Coils on bodies and obstacles, and bearings.
#include <algorithm>
#include <cmath>

#include "core/magnetics/induction/flux_linkage.h"
#include "core/magnetics/induction/mutual_inductance.h"
#include "core/electrodynamics/currents.h"
#include "core/sim/model/build.h"
#include "core/sim/model/motion.h"

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

void check_coil(const Coil& coil, const std::string& where) {
  check_fields(coil, where);
  require(coil.shape == "loop" || coil.shape == "solenoid",
          where + ".shape must be loop or solenoid, got \"" + coil.shape + "\"");
  require((coil.shape == "solenoid") == (coil.length > 0.0),
          where + ".length must be > 0 [m] for a solenoid and left out for a loop");
  require(coil.position.allFinite() && coil.commutator.allFinite(),
          where + ".position and commutator must be finite");
  require(std::abs(coil.orientation.norm() - 1.0) < 1e-6,
          where + ".orientation must be a unit quaternion (w, x, y, z)");
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

void build_bearings(const Scene& scene, Model& model) {
  model.bearing_of_body.assign(scene.bodies.size(), -1);
  if (!scene.bearings.empty() && !scene.cloths.empty())
    throw Unsupported(
        "scene.bearings hold bodies among bodies, not beside cloth; leave out the cloths or the "
        "bearings");
  for (std::size_t i = 0; i < scene.bearings.size(); ++i) {
    const Bearing& bearing = scene.bearings[i];
    const std::string where = "bearings[" + std::to_string(i) + "]";
    check_fields(bearing, where);
    const std::size_t body = find_by_name(scene.bodies, bearing.body, where + ".body");
    require(model.bearing_of_body[body] < 0,
            where + ".body has a bearing already; a body turns in one");
    require(bearing.axis.allFinite() && bearing.axis.norm() > 0.0,
            where + ".axis must be finite and not zero");
    const Vec3 axis = bearing.axis.normalized();
    const Mat3 inertia =
        world_inertia(model.body_mass[body], scene.bodies[body].orientation.normalized());
    const Vec3 momentum = inertia * axis;
    require((momentum - momentum.dot(axis) * axis).norm() <= 1e-3 * momentum.norm(),
            where +
                ".axis must be a principal axis of the body's inertia (within 1e-3); turn the body "
                "or balance it");
    model.bearing_of_body[body] = static_cast<int>(i);
  }
}

}  // namespace

void build_coils(const Scene& scene, Model& model) {
  build_bearings(scene, model);
  for (std::size_t i = 0; i < scene.coils.size(); ++i) {
    const Coil& coil = scene.coils[i];
    const std::string where = "coils[" + std::to_string(i) + "]";
    check_coil(coil, where);
    if (coil.resistance > 0.0 && scene.bodies.empty())
      throw Unsupported(where +
                        ": circuits are advanced together with rigid bodies, got a scene without "
                        "one; add a body anywhere");
    const std::size_t carrier = find_carrier(scene, coil.body, where + ".body");
    Model::Wound wound;
    wound.carrier = static_cast<Index>(carrier);
    wound.local = {coil.position, coil.orientation.normalized()};
    if (carrier < scene.bodies.size()) wound.local.position -= model.body_mass[carrier].centre;
    wound.source = wound_source(coil, 1.0);
    model.coils.push_back(std::move(wound));
  }
  for (std::size_t i = 0; i < scene.coils.size(); ++i)
    for (const Magnet& magnet : scene.magnets) {
      if (scene.coils[i].resistance == 0.0 || magnet.susceptibility == 0.0) continue;
      const std::string where = "coils[" + std::to_string(i) + "]";
      if (magnet.saturation > 0.0 || magnet.response == "explicit")
        throw Unsupported(
            where +
            ": circuits want bodies that magnetise to do so linearly and mutually, got one with " +
            (magnet.saturation > 0.0 ? "saturation" : "the explicit response") +
            "; leave that out, or give the coil a current");
      require(scene.coils[i].inductance > 0.0, where +
                                                   ".inductance must be > 0 [H] beside bodies that "
                                                   "magnetise; give it that of the winding in air");
    }
}

void check_coils(const Model& model, const State& state) {
  const std::vector<RigidPose> obstacles = obstacle_places(model, state, 0.0, 1.0).poses;
  const auto pose_of = [&](const auto& part) {
    return carried_pose(state.rigid, obstacles, part.carrier, part.local);
  };
  std::vector<Index> circuits;
  const bool any_circuit = std::any_of(model.scene.coils.begin(), model.scene.coils.end(),
                                       [](const Coil& coil) { return coil.resistance > 0.0; });
  for (std::size_t j = 0; j < model.coils.size(); ++j) {
    const std::string where = "coils[" + std::to_string(j) + "]";
    if (model.scene.coils[j].resistance > 0.0) circuits.push_back(static_cast<Index>(j));
    for (std::size_t k = 0; k < model.magnets.size(); ++k) {
      const Model::Carried& magnet = model.magnets[k];
      if (magnet.source) continue;
      const SourcePtr solid =
          magnet.soft ? magnet.soft->solid() : nullptr;  // null: a sphere that is taken as a dipole
      const double radius = solid ? solid->radius() : magnet.radius;
      const RigidPose pose = relative_pose(pose_of(model.coils[j]), pose_of(magnet));
      const Mat3 rotation = rotation_matrix(pose.orientation);
      for (const Panel& panel : model.coils[j].source->panels())
        for (int i = 0; i < 64; ++i) {
          const Vec3 point = panel.at(i % 8 / 7.0, panel.line() ? 0.0 : i / 8 / 7.0).position;
          const Vec3 there = pose.position + rotation * point;
          require(
              (solid ? solid->depth(there) : radius - there.norm()) <= 1e-6 * radius,
              where +
                  " must lie apart from bodies that magnetise, got a winding that goes into one");
        }
      if (!solid || !any_circuit || !wants_flux(model.scene.coils[j])) continue;
      const BesideWinding beside = beside_winding({model.coils[j].source, pose_of(model.coils[j])},
                                                  {solid, pose_of(magnet)});
      if (beside.in_bore && beside.outside)
        throw Unsupported(where +
                          ": circuits want bodies that magnetise in the bore or beside the "
                          "winding, got magnets[" +
                          std::to_string(k) + "], which reaches round it; split the body");
    }
  }
  const auto m = static_cast<Eigen::Index>(circuits.size());
  Eigen::MatrixXd inductances(m, m);
  for (Eigen::Index a = 0; a < m; ++a) {
    inductances(a, a) = model.scene.coils[circuits[a]].inductance;
    for (Eigen::Index b = 0; b < a; ++b)
      inductances(a, b) = inductances(b, a) = mutual_inductance(
          {model.coils[circuits[b]].source, pose_of(model.coils[circuits[b]])},
          {model.coils[circuits[a]].source, pose_of(model.coils[circuits[a]])}, 1e-4);
  }
  if (m < 2) return;
  require(inductances.llt().info() == Eigen::Success,
          "circuits must have inductances [H] whose mutual ones M keep M^2 < L_1 L_2, got M = " +
              std::to_string(inductances(1, 0)) +
              " H of the first two; give them the inductance of their winding");
}

}  // namespace loomstone
