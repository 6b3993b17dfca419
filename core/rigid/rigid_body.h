// Rigid bodies: what the user asks for (RigidBody), what changes (RigidState), and the world that
// moves them.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/base/field.h"
#include "core/base/rotation.h"
#include "core/base/types.h"
#include "core/mesh/triangle_mesh.h"

namespace loomstone {

// Description.
struct RigidBody {
  std::string name;
  std::shared_ptr<const TriangleMesh> mesh;  // closed, in the body's own frame
  std::string shape =
      "convex";  // "sphere" | "box" | "convex" | "parts" (parts = convex meshes below)
  std::vector<std::shared_ptr<const TriangleMesh>>
      parts;  // convex decomposition, same frame as mesh
  double density = 1000.0;
  Vec3 position = Vec3::Zero();          // of the mesh's origin [m]
  Vec4 orientation = Vec4(1, 0, 0, 0);   // unit quaternion w, x, y, z, body to world
  Vec3 velocity = Vec3::Zero();          // of the centre of mass [m/s]
  Vec3 angular_velocity = Vec3::Zero();  // world [rad/s]
  double friction = 0.3;
  double restitution = 0.0;
  double thickness = 0.0;  // contact distance to cloth, 0: as the cloth's

  static auto fields() {
    return std::make_tuple(
        field("name", &RigidBody::name, "name in reports and files"),
        field("mesh", &RigidBody::mesh, "closed surface in the body's own frame"),
        field("shape", &RigidBody::shape,
              "collision shape between bodies: sphere | box | convex | parts"),
        field("parts", &RigidBody::parts, "convex parts when shape is parts"),
        field("density", &RigidBody::density, "kg/m^3", positive(), "density"),
        field("position", &RigidBody::position, "world position of the mesh's origin [m]"),
        field("orientation", &RigidBody::orientation,
              "unit quaternion (w, x, y, z), body to world"),
        field("velocity", &RigidBody::velocity, "velocity of the centre of mass [m/s]"),
        field("angular_velocity", &RigidBody::angular_velocity,
              "angular velocity in world axes [rad/s]"),
        field("friction", &RigidBody::friction, "1", non_negative(), "friction coefficient"),
        field("restitution", &RigidBody::restitution, "1", between(0.0, 1.0),
              "restitution coefficient"),
        field("thickness", &RigidBody::thickness, "m", non_negative(),
              "contact distance to cloth, 0: as the cloth's"));
  }
};

// Mass, centre and inertia of a closed mesh of uniform density (Mirtich 1996 by signed tetrahedra).
struct MassProperties {
  double mass = 0.0;            // [kg]
  Vec3 centre = Vec3::Zero();   // [m] in the mesh's frame
  Mat3 inertia = Mat3::Zero();  // about the centre, mesh axes [kg m^2]
};
MassProperties mass_properties(const TriangleMesh& mesh,
                               double density);  // throws InvalidInput when open or inside out

// State. Quaternions are (w, x, y, z); positions are of the centre of mass.
struct RigidState {
  Points positions;  // (b x 3) [m], written by the rigid stage
  Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor> orientations;  // (b x 4), rigid stage
  Points velocities;                     // (b x 3) [m/s], rigid stage
  Points angular_velocities;             // (b x 3) [rad/s], rigid stage
  std::vector<unsigned char> manifolds;  // contact points carried over a rebuild, opaque
};

// Throws unless a state has a row for each of n bodies (InvalidInput) or unless it is finite after
// a step (SolverFailure).
void check_rows(const RigidState& state, Index n);
void check_motion(const RigidState& state, double step);

// Throws InvalidInput unless there is a row for each of n bodies.
void check_impulses(const Points& impulses, const Points& angular_impulses, const RigidState& state,
                    Index n);

// State of the bodies as described.
RigidState start_state(const std::vector<RigidBody>& bodies,
                       const std::vector<MassProperties>& masses);

// Pose of a body's centre of mass.
inline RigidPose body_pose(const RigidState& state, Index body) {
  return {state.positions.row(body).transpose(), state.orientations.row(body).transpose()};
}
// Inertia about the centre in world axes [kg m^2].
Mat3 world_inertia(const MassProperties& mass, const Vec4& orientation);
// World position [m] of a point given relative to the centre of mass in body axes [m], and back.
Vec3 to_world(const RigidState& state, Index body, const Vec3& local);
Vec3 to_body(const RigidState& state, Index body, const Vec3& world);
// Velocity [m/s] of the body's material at a world position.
Vec3 velocity_at(const RigidState& state, Index body, const Vec3& world);
// (n x 3) world positions of the mesh that the body carries.
Points world_vertices(const RigidState& state, Index body, const TriangleMesh& mesh,
                      const MassProperties& mass);

// A surface that bodies bounce off and that does not feel them: static, or moved by script.
struct RigidObstacle {
  std::shared_ptr<const TriangleMesh> mesh;
  double friction = 0.3;
  Vec3 position = Vec3::Zero();         // of the mesh's origin at the start [m]
  Vec4 orientation = Vec4(1, 0, 0, 0);  // at the start
  Points vertices =
      Points(0, 3);  // (n x 3) of one that deforms, in the world at the start [m]; else empty
};

// Where obstacles are: the poses of their meshes' origins, one each, and the vertices of those that
// deform, end to end [m].
struct ObstaclePlaces {
  ObstaclePlaces(std::vector<RigidPose> p = {}, Points d = Points(0, 3))
      : poses(std::move(p)), deformed(std::move(d)) {}
  std::vector<RigidPose> poses;
  Points deformed;  // (k x 3)
};
ObstaclePlaces between(const ObstaclePlaces& start, const ObstaclePlaces& end, double share);
// Throws InvalidInput unless there are as many of each.
void check_places(const ObstaclePlaces& given, const ObstaclePlaces& expected);

// (n) 1 for bodies from which pairs that press on one another lead to an obstacle (numbered from
// n).
std::vector<std::uint8_t> bodies_on_obstacles(int n,
                                              const std::vector<std::array<int, 2>>& pressed);

// Stage. Bullet behind this class alone; body-body and body-obstacle contacts only (cloth comes in
// as impulses).
class RigidWorld {
 public:
  // With 50 sweeps over all contacts cubes of 1 cm stay at rest at steps of 1 ms; with 10 stacks
  // creep.
  static constexpr int default_iterations = 50;

  // gyroscopic: spinning bodies feel their own inertia; false where another stage turns them
  // between contacts. Throws InvalidInput for open meshes, unknown shapes, bodies without volume.
  RigidWorld(const std::vector<RigidBody>& bodies, const std::vector<RigidObstacle>& obstacles,
             const Vec3& gravity, bool gyroscopic = true, int iterations = default_iterations);
  ~RigidWorld();

  // Initial state of the described bodies.
  RigidState initial_state() const;
  // Mass and inertia about the centre in body axes (the body frame's axes are the mesh's, its
  // origin the centre of mass).
  const std::vector<MassProperties>& mass_properties() const;

  // A new world holding exactly `state` (manifolds carried): the future depends on `state` alone.
  void restore(const RigidState& state);
  // Advances by `step`; impulses [N s] and angular impulses [N m s] (b x 3) about the centres act
  // first. Obstacles are where they will be at the end of the step, with the velocities that lead
  // there. touched, if wanted: (b) 1 for bodies that did not move freely.
  void advance(double step, const Points& impulses, const Points& angular_impulses,
               const ObstaclePlaces& obstacles, RigidState& state,
               std::vector<std::uint8_t>* touched = nullptr);
  // (b) 1 for bodies that touched something in the last step, or came within some hundredths of
  // their size of it since they did.
  std::vector<std::uint8_t> touching() const;
  // (b) 1 for bodies that the last step pressed on an obstacle, directly or over other bodies.
  std::vector<std::uint8_t> supported() const;
  // Writes the manifolds into `state` so that restore() continues bit for bit.
  void save(RigidState& state) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace loomstone
