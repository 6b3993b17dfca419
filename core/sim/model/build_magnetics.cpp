// Checks and builds the magnets, coils, bearings and the uniform field. If there are magnets, also
// builds the magnetic polarity at each vertex of bodies and obstacles, for rendering.
#include "core/base/error.h"
#include "core/base/message.h"
#include "core/sim/model/build.h"
#include "core/sim/model/motion.h"

namespace loomstone {

namespace {

MagneticScene magnetic_scene(const Scene& scene, const Model& model) {
  MagneticScene magnetic;
  magnetic.magnets = scene.magnets, magnetic.coils = scene.coils;
  magnetic.bearings = scene.bearings;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const RigidBody& body = scene.bodies[b];
    magnetic.carriers.push_back(
        {body.name, body.mesh, model.body_mass[b], body.orientation, false});
  }
  for (const Obstacle& obstacle : scene.obstacles)
    magnetic.carriers.push_back(
        {obstacle.name, obstacle.mesh, {}, Vec4(1, 0, 0, 0), obstacle.vertex_positions.rows() > 0});
  magnetic.n_bodies = static_cast<Index>(scene.bodies.size());
  magnetic.gravity = scene.gravity, magnetic.field = scene.magnetic_field;
  magnetic.tolerance = scene.magnetic_tolerance, magnetic.substep = scene.magnetic_step;
  return magnetic;
}

// Throws InvalidInput if the initial motion of a body with a bearing is not a rotation about the
// axis of the bearing.
void check_guided_motion(const Scene& scene, const MagneticModel& model) {
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    if (!model.bodies[b].bearing) continue;
    const RigidBody& body = scene.bodies[b];
    const Vec3& axis = model.bodies[b].bearing->axis;
    if (!body.velocity.isZero(0.0))
      fail<InvalidInput>(
          "bodies[{}].velocity must be 0 [m/s], because a bearing holds the centre of the body; "
          "leave it out",
          b);
    const Vec3 across = body.angular_velocity - body.angular_velocity.dot(axis) * axis;
    if (across.norm() > 1e-6 * body.angular_velocity.norm())
      fail<InvalidInput>(
          "bodies[{}].angular_velocity must be parallel to the axis of its bearing, got {:.6g} "
          "rad/s across it; use a multiple of the axis",
          b, across.norm());
  }
}

void build_poles(Model& model) {
  std::vector<double>& pole = model.topology.body_pole;
  pole.clear();
  Index carrier = 0;
  for (const auto* surfaces : {&model.bodies, &model.obstacles})
    for (const Model::Surface& surface : *surfaces) {
      for (Index i = 0; i < surface.local.rows(); ++i)
        pole.push_back(pole_at(model.magnetics, carrier, surface.local.row(i).transpose()));
      ++carrier;
    }
}

}  // namespace

void build_magnetics(const Scene& scene, Model& model) {
  if (!scene.magnetic_field.allFinite())
    throw InvalidInput("scene.magnetic_field must be finite [T]");
  if (!scene.magnetic_field.isZero(0.0) && scene.magnets.empty() && scene.coils.empty())
    throw InvalidInput(
        "scene.magnetic_field must be 0 [T] in a scene without magnets and coils; add magnets or "
        "coils, or omit the field");
  if (!scene.bearings.empty() && !scene.cloths.empty())
    throw Unsupported(
        "scene.bearings require a scene without cloth; leave out the cloths or the bearings");
  model.magnetics = build_magnetic_model(magnetic_scene(scene, model));
  check_guided_motion(scene, model.magnetics);
  if (!scene.magnets.empty()) build_poles(model);
}

void check_magnetics(const Model& model, const State& state) {
  check_magnetic_start(model.magnetics,
                       {state.rigid, obstacle_places(model, state, 0.0, 1.0).poses});
}

}  // namespace loomstone
