#include "core/collision/response/retraction.h"

#include <algorithm>
#include <cmath>

namespace loomstone {

namespace {

// A surface of which a part has passed through another surface moves back relative to it, at least
// at the speed sqrt(2 deceleration depth), where depth is Retraction::depth. From this speed,
// `deceleration` would stop it after the distance depth. The surface reaches this speed with a
// relative acceleration of at most `largest_acceleration`. Each retraction of a surface is computed
// as if it were the only one, and the accelerations add up. Both constants are in m/s^2. Our
// choice: if half of a sheet of 0.2 m has passed through, it comes back within 0.3 s.
constexpr double deceleration = 4.0, largest_acceleration = 15.0;

// A surface that is treated as a rigid body: its inertia, its motion, and its response to forces.
struct RigidSurface {
  double inverse_mass = 0.0;  // [1/kg], 0: does not accelerate
  Mat3 inverse_inertia = Mat3::Zero();
  Vec3 centre = Vec3::Zero(), velocity = Vec3::Zero(), spin = Vec3::Zero();

  Vec3 velocity_at(const Vec3& point) const { return velocity + spin.cross(point - centre); }
  // Returns the acceleration at `point` [1/kg] due to a unit force along `direction` that acts at
  // the point `at`.
  Vec3 response(const Vec3& point, const Vec3& at, const Vec3& direction) const {
    const Vec3 turn = inverse_inertia * (at - centre).cross(direction);
    return inverse_mass * direction + turn.cross(point - centre);
  }
};

bool accelerates(const CollisionModel& model, const Vector& inverse_mass,
                 const std::vector<Index>& vertices) {
  return std::all_of(vertices.begin(), vertices.end(), [&](Index v) {
    return model.surfaces[model.surface_of_vertex(v)].kind == CollisionSurface::Kind::Cloth &&
           inverse_mass[v] > 0.0;
  });
}

RigidSurface rigid_surface(const CollisionModel& model, const Vector& inverse_mass,
                           const std::vector<Index>& vertices, const Points& x,
                           const Points& velocity) {
  const bool free = accelerates(model, inverse_mass, vertices);
  const auto mass_of = [&](Index v) { return free ? 1.0 / inverse_mass[v] : 1.0; };
  RigidSurface surface;
  double mass = 0.0;
  for (const Index v : vertices) {
    mass += mass_of(v);
    surface.centre += mass_of(v) * x.row(v).transpose();
    surface.velocity += mass_of(v) * velocity.row(v).transpose();
  }
  surface.centre /= mass;
  surface.velocity /= mass;
  if (!free) return surface;
  surface.inverse_mass = 1.0 / mass;
  Mat3 inertia = Mat3::Zero();
  Vec3 angular_momentum = Vec3::Zero();
  for (const Index v : vertices) {
    const Vec3 arm = x.row(v).transpose() - surface.centre;
    inertia += mass_of(v) * (arm.squaredNorm() * Mat3::Identity() - arm * arm.transpose());
    angular_momentum += mass_of(v) * arm.cross(velocity.row(v).transpose());
  }
  surface.inverse_inertia = inertia.inverse();
  surface.spin = surface.inverse_inertia * angular_momentum;
  return surface;
}

}  // namespace

RetractedMotion retracted_motion(const CollisionModel& model, const Tangle& tangle,
                                 const Vector& inverse_mass, const Points& x,
                                 const Points& velocity, double step) {
  RetractedMotion motion;
  if (tangle.retractions.empty()) return motion;
  motion.acceleration = Points::Zero(x.rows(), 3);
  motion.velocity = velocity;
  for (const Retraction& each : tangle.retractions) {
    const RigidSurface inner = rigid_surface(model, inverse_mass, each.inner, x, velocity);
    const RigidSurface outer = rigid_surface(model, inverse_mass, each.outer, x, velocity);
    const Vec3 along = each.direction;
    const double response = along.dot(inner.response(each.point, each.point, along) +
                                      outer.response(each.point, each.point, along));
    if (!(response > 0.0)) continue;
    const double wanted = std::sqrt(2.0 * deceleration * each.depth);
    const double speed = along.dot(inner.velocity_at(each.point) - outer.velocity_at(each.point));
    const double change = std::clamp((wanted - speed) / step, 0.0, largest_acceleration);
    const auto push = [&](const RigidSurface& surface, const std::vector<Index>& vertices,
                          double force) {
      for (const Index v : vertices) {
        const Vec3 place = x.row(v).transpose();
        motion.acceleration.row(v) +=
            force * surface.response(place, each.point, along).transpose();
        motion.velocity.row(v) =
            surface.velocity_at(place).transpose() + step * motion.acceleration.row(v);
      }
    };
    push(inner, each.inner, change / response);
    push(outer, each.outer, -change / response);
  }
  return motion;
}

}  // namespace loomstone
