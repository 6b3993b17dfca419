// Kinematics of rigid bodies and checks of their state.
#include "core/rigid/rigid_body.h"

#include "core/base/message.h"

namespace loomstone {

ObstaclePlaces between(const ObstaclePlaces& start, const ObstaclePlaces& end, double share) {
  ObstaclePlaces places;
  for (std::size_t i = 0; i < start.poses.size(); ++i)
    places.poses.push_back(between(start.poses[i], end.poses[i], share));
  places.deformed = share == 1.0 ? end.deformed
                                 : Points(start.deformed + share * (end.deformed - start.deformed));
  return places;
}

void check_places(const ObstaclePlaces& given, const ObstaclePlaces& expected) {
  if (given.poses.size() == expected.poses.size() &&
      given.deformed.rows() == expected.deformed.rows())
    return;
  fail<InvalidInput>(
      "there must be one pose for each of the {} obstacles, and {} vertices of obstacles that "
      "deform, got {} poses and {} vertices; give the poses and vertices of all obstacles",
      expected.poses.size(), expected.deformed.rows(), given.poses.size(), given.deformed.rows());
}

void check_rows(const RigidState& state, Index n) {
  if (state.positions.rows() == n && state.orientations.rows() == n &&
      state.velocities.rows() == n && state.angular_velocities.rows() == n)
    return;
  fail<InvalidInput>(
      "the tables of a rigid state must have one row for each of the {} bodies, got {} positions, "
      "{} orientations, {} velocities and {} angular velocities; load the state with the scene "
      "from which it was saved",
      n, state.positions.rows(), state.orientations.rows(), state.velocities.rows(),
      state.angular_velocities.rows());
}

void check_motion(const RigidState& state, double step) {
  for (Eigen::Index i = 0; i < state.positions.rows(); ++i)
    if (!state.positions.row(i).allFinite() || !state.velocities.row(i).allFinite() ||
        !state.orientations.row(i).allFinite() || !state.angular_velocities.row(i).allFinite())
      fail<SolverFailure>(
          "bodies[{}] must stay finite, got NaN or infinity from the rigid-body step of {} s; "
          "shorten integrator.step or look for extreme impulses",
          i, step);
}

void check_impulses(const Points& impulses, const Points& angular_impulses, const RigidState& state,
                    Index n) {
  if (impulses.rows() == n && angular_impulses.rows() == n && state.positions.rows() == n) return;
  fail<InvalidInput>(
      "impulses, angular impulses and state must have one row for each of the {} bodies, got {}, "
      "{} and {}; resize them",
      n, impulses.rows(), angular_impulses.rows(), state.positions.rows());
}

std::vector<std::uint8_t> bodies_on_obstacles(int n,
                                              const std::vector<std::array<int, 2>>& pressed) {
  std::vector<std::uint8_t> held(n, 0);
  const auto holds = [&](int i) { return i >= n || held[i]; };
  for (bool grown = true; grown;) {
    grown = false;
    for (const auto& [a, b] : pressed) {
      if (holds(a) == holds(b)) continue;
      held[holds(a) ? b : a] = 1, grown = true;
    }
  }
  return held;
}

RigidState start_state(const std::vector<RigidBody>& bodies,
                       const std::vector<MassProperties>& masses) {
  const auto n = static_cast<Eigen::Index>(bodies.size());
  RigidState state;
  state.positions.resize(n, 3);
  state.orientations.resize(n, 4);
  state.velocities.resize(n, 3);
  state.angular_velocities.resize(n, 3);
  for (Eigen::Index i = 0; i < n; ++i) {
    const RigidBody& body = bodies[i];
    const Vec4 orientation = body.orientation.normalized();
    state.positions.row(i) =
        (body.position + rotation_matrix(orientation) * masses[i].centre).transpose();
    state.orientations.row(i) = orientation.transpose();
    state.velocities.row(i) = body.velocity.transpose();
    state.angular_velocities.row(i) = body.angular_velocity.transpose();
  }
  return state;
}

Mat3 world_inertia(const MassProperties& mass, const Vec4& orientation) {
  const Mat3 rotation = rotation_matrix(orientation);
  return rotation * mass.inertia * rotation.transpose();
}

Vec3 to_world(const RigidState& state, Index body, const Vec3& local) {
  return state.positions.row(body).transpose() +
         rotation_matrix(state.orientations.row(body).transpose()) * local;
}

Vec3 to_body(const RigidState& state, Index body, const Vec3& world) {
  const Vec3 arm = world - state.positions.row(body).transpose();
  return rotation_matrix(state.orientations.row(body).transpose()).transpose() * arm;
}

Vec3 velocity_at(const RigidState& state, Index body, const Vec3& world) {
  const Vec3 arm = world - state.positions.row(body).transpose();
  const Vec3 spin = state.angular_velocities.row(body).transpose();
  return state.velocities.row(body).transpose() + spin.cross(arm);
}

Points body_velocities(const RigidState& state) {
  Points velocities(2 * state.velocities.rows(), 3);
  for (Index b = 0; b < state.velocities.rows(); ++b) {
    velocities.row(2 * b) = state.velocities.row(b);
    velocities.row(2 * b + 1) = state.angular_velocities.row(b);
  }
  return velocities;
}

Points world_vertices(const RigidState& state, Index body, const TriangleMesh& mesh,
                      const MassProperties& mass) {
  const Mat3 rotation = rotation_matrix(state.orientations.row(body).transpose());
  Points world(mesh.n_vertices(), 3);
  for (Index i = 0; i < mesh.n_vertices(); ++i) {
    const Vec3 local = mesh.vertices().row(i).transpose() - mass.centre;
    world.row(i) = (state.positions.row(body).transpose() + rotation * local).transpose();
  }
  return world;
}

}  // namespace loomstone
