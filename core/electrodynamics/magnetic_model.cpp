#include "core/electrodynamics/magnetic_model.h"

#include <algorithm>

#include "core/base/find_by_name.h"
#include "core/base/message.h"
#include "core/electrodynamics/build.h"

namespace loomstone {

bool MagneticModel::acts() const {
  const auto turns = [](const MagneticRotor& body) { return body.bearing.has_value(); };
  return !magnets.empty() || !coils.empty() || std::any_of(bodies.begin(), bodies.end(), turns);
}

BearingAxes MagneticModel::bearing_axes() const {
  BearingAxes axes;
  for (const MagneticRotor& body : bodies)
    axes.push_back(body.bearing ? std::optional(body.bearing->axis) : std::nullopt);
  return axes;
}

Stand find_stand(const MagneticScene& scene, const std::string& name, const RigidPose& in_mesh,
                 const std::string& where) {
  if (name.empty())
    fail<InvalidInput>("{} must be the name of the body or obstacle that carries it, got none",
                       where);
  const std::size_t carrier = find_by_name(scene.carriers, name, where);
  if (scene.carriers[carrier].deforms)
    fail<Unsupported>("{} must keep its shape, got an obstacle that deforms by vertex_positions",
                      where);
  Stand stand{static_cast<Index>(carrier), in_mesh};
  if (stand.carrier < scene.n_bodies) stand.local.position -= scene.carriers[carrier].mass.centre;
  return stand;
}

MagneticModel build_magnetic_model(const MagneticScene& scene) {
  MagneticModel model;
  model.gravity = scene.gravity, model.field = scene.field;
  model.tolerance = scene.tolerance, model.substep = scene.substep;
  for (Index b = 0; b < scene.n_bodies; ++b) {
    const MassProperties& mass = scene.carriers[b].mass;
    model.bodies.push_back({mass, make_rotor(mass.inertia), {}});
  }
  model.n_obstacles = static_cast<Index>(scene.carriers.size()) - scene.n_bodies;
  add_magnets(scene, model);
  add_bearings(scene, model);
  add_coils(scene, model);
  return model;
}

void check_magnetic_start(const MagneticModel& model, const CarrierPlaces& start) {
  check_magnets(model, start);
  check_coils(model, start);
}

}  // namespace loomstone
