// Rigid bodies: description (RigidBody), state (RigidState), and the world that moves them
// (RigidWorld).
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/choice.h"
#include "core/base/field.h"
#include "core/base/look.h"
#include "core/base/rotation.h"
#include "core/base/types.h"
#include "core/mesh/triangle_mesh.h"

namespace loomstone {

enum class BodyShape { Sphere, Box, Convex, Parts };
constexpr auto choices(BodyShape) {
  return std::array{ChoiceName{BodyShape::Sphere, "sphere"}, ChoiceName{BodyShape::Box, "box"},
                    ChoiceName{BodyShape::Convex, "convex", "convex hull of the mesh"},
                    ChoiceName{BodyShape::Parts, "parts", "the convex meshes in parts"}};
}

struct RigidBody {
  std::string name;
  std::shared_ptr<const TriangleMesh> mesh;  // closed, in the body's own frame
  BodyShape shape = BodyShape::Convex;
  std::vector<std::shared_ptr<const TriangleMesh>> parts;  // convex, same frame as mesh
  // Density [kg/m^3], used if `mass` is 0.
  double density = 1000.0;
  double mass = 0.0;                     // [kg]; 0: density times volume
  Vec3 position = Vec3::Zero();          // world position of the origin of the mesh [m]
  Vec4 orientation = Vec4(1, 0, 0, 0);   // unit quaternion (w, x, y, z), body to world
  Vec3 velocity = Vec3::Zero();          // velocity of the centre of mass [m/s]
  Vec3 angular_velocity = Vec3::Zero();  // in world axes [rad/s]
  double friction = 0.3;
  double restitution = 0.0;
  // Thickness in contacts with cloth [m]; the contact distance is the mean of this and the cloth's
  // thickness. 0: the largest thickness of a cloth, or 1 mm without cloth.
  double thickness = 0.0;
  std::optional<Look> look;

  static auto fields() {
    return std::make_tuple(
        field("name", &RigidBody::name, "name in reports and files"),
        field("mesh", &RigidBody::mesh, "closed surface in the body's own frame"),
        field("shape", &RigidBody::shape, "shape in contacts with bodies and obstacles"),
        field("parts", &RigidBody::parts, "convex meshes of the shape \"parts\""),
        field("density", &RigidBody::density, "kg/m^3", positive(),
              "density, used if the mass is 0"),
        field("mass", &RigidBody::mass, "kg", non_negative(),
              "mass, spread evenly over the volume; 0: density times volume"),
        field("position", &RigidBody::position, "world position of the mesh's origin [m]"),
        field("orientation", &RigidBody::orientation,
              "unit quaternion (w, x, y, z), body to world"),
        field("velocity", &RigidBody::velocity, "velocity of the centre of mass [m/s]"),
        field("angular_velocity", &RigidBody::angular_velocity,
              "angular velocity in world axes [rad/s]"),
        field("friction", &RigidBody::friction, "1", non_negative(), "friction coefficient"),
        field("restitution", &RigidBody::restitution, "1", between(0.0, 1.0),
              "coefficient of restitution"),
        field("thickness", &RigidBody::thickness, "m", non_negative(),
              "thickness; cloth touches it at the mean of both thicknesses; 0: the largest of the "
              "cloths, or 1 mm without cloth"),
        field("look", &RigidBody::look,
              "Look: its colour and texture in pictures; None: the renderer's default"));
  }
};

// Volume, mass, centre and inertia of a closed mesh of uniform density [Mirtich1996].
struct MassProperties {
  double volume = 0.0;          // [m^3]
  double mass = 0.0;            // [kg]
  Vec3 centre = Vec3::Zero();   // centre of mass in the mesh's frame [m]
  Mat3 inertia = Mat3::Zero();  // about the centre of mass, in mesh axes [kg m^2]
};
// Throws InvalidInput if the mesh is missing, open or inside out, or encloses no volume.
MassProperties mass_properties(const TriangleMesh& mesh, double density);
MassProperties mass_properties(const RigidBody& body);

// State of all b bodies. Positions and velocities are those of the centres of mass. Angular
// velocities are in world axes. Quaternions are (w, x, y, z), body to world.
struct RigidState {
  Points positions;                                                        // (b x 3) [m]
  Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor> orientations;  // (b x 4)
  Points velocities;                                                       // (b x 3) [m/s]
  Points angular_velocities;                                               // (b x 3) [rad/s]
  // Serialised contacts and obstacle positions for RigidWorld::restore().
  std::vector<unsigned char> manifolds;
};

// Impulses [N s] and angular impulses [N m s] on all bodies (b x 3 each).
struct BodyImpulses {
  Points linear, angular;
};

// Throws InvalidInput unless each table of `state` has one row for each of n bodies.
void check_rows(const RigidState& state, Index n);
// Throws SolverFailure if the state after a step of length `step` [s] is not finite.
void check_motion(const RigidState& state, double step);

// Throws InvalidInput unless both arrays and `state.positions` have one row for each of n bodies.
void check_impulses(const Points& impulses, const Points& angular_impulses, const RigidState& state,
                    Index n);

// Returns the initial state of the bodies.
RigidState start_state(const std::vector<RigidBody>& bodies,
                       const std::vector<MassProperties>& masses);

// Pose of a body. Its position is that of the centre of mass.
inline RigidPose body_pose(const RigidState& state, Index body) {
  return {state.positions.row(body).transpose(), state.orientations.row(body).transpose()};
}
// (2 b x 3) Row 2 i is the velocity of body i [m/s], row 2 i + 1 its angular velocity [rad/s].
Points body_velocities(const RigidState& state);
// Inertia about the centre of mass in world axes [kg m^2].
Mat3 world_inertia(const MassProperties& mass, const Vec4& orientation);
// to_world() returns the world position [m] of a point whose position in body axes, relative to the
// centre of mass, is `local` [m]. to_body() is the inverse of to_world().
Vec3 to_world(const RigidState& state, Index body, const Vec3& local);
Vec3 to_body(const RigidState& state, Index body, const Vec3& world);
// Velocity [m/s] of the body's material at a world position.
Vec3 velocity_at(const RigidState& state, Index body, const Vec3& world);
// Returns the world positions (n x 3) of the vertices of a body's mesh.
Points world_vertices(const RigidState& state, Index body, const TriangleMesh& mesh,
                      const MassProperties& mass);

// A surface that acts on bodies but is not moved by them. It is static or has scripted motion.
struct RigidObstacle {
  std::shared_ptr<const TriangleMesh> mesh;
  double friction = 0.3;
  Vec3 position = Vec3::Zero();         // position of the mesh's origin at the start [m]
  Vec4 orientation = Vec4(1, 0, 0, 0);  // orientation at the start
  // (n x 3) World positions [m] of the vertices at the start if the obstacle deforms; else empty.
  Points vertices = Points(0, 3);
};

// Poses of all obstacles, and the vertices of all deforming obstacles, concatenated [m]. The
// position of a pose is that of the mesh's origin.
struct ObstaclePlaces {
  ObstaclePlaces(std::vector<RigidPose> p = {}, Points d = Points(0, 3))
      : poses(std::move(p)), deformed(std::move(d)) {}
  std::vector<RigidPose> poses;
  Points deformed;  // (k x 3)
};
ObstaclePlaces between(const ObstaclePlaces& start, const ObstaclePlaces& end, double share);
// Throws InvalidInput unless `given` and `expected` have the same numbers of poses and vertices.
void check_places(const ObstaclePlaces& given, const ObstaclePlaces& expected);

// Returns an array (n) that is 1 for bodies that press on an obstacle, directly or through other
// bodies. `pressed` lists the pairs that press on each other; indices from n on are obstacles.
std::vector<std::uint8_t> bodies_on_obstacles(int n,
                                              const std::vector<std::array<int, 2>>& pressed);

// For each body: the axis of its bearing (unit vector in world axes), or no value if the body moves
// freely. An empty vector means that no body has a bearing.
using BearingAxes = std::vector<std::optional<Vec3>>;

// Moves the bodies and resolves their contacts with each other and with obstacles. Cloth acts on
// bodies only by impulses. No Bullet type appears in this interface.
class RigidWorld {
 public:
  // Number of sweeps over all contacts in each step. With 50 sweeps and steps of 1 ms, a stack of
  // cubes of 1 cm stays at rest. With far fewer sweeps, it creeps.
  static constexpr int default_iterations = 50;

  // If `gyroscopic` is true, gyroscopic torques act on bodies without a bearing. Otherwise, the
  // caller must compute the free rotation of the bodies. Throws InvalidInput for fields out of
  // range, quaternions without unit length, missing meshes or parts, meshes that mass_properties()
  // rejects, spheres whose mesh is not round, boxes whose mesh is not a box, and flat hulls.
  // `axes` is empty or has an entry for each body. A body with an axis (unit vector in world
  // axes) only turns about it: its centre of mass does not move. The axis must be a principal axis
  // of the body's inertia.
  RigidWorld(const std::vector<RigidBody>& bodies, const std::vector<RigidObstacle>& obstacles,
             const Vec3& gravity, bool gyroscopic = true, int iterations = default_iterations,
             const BearingAxes& axes = {});
  ~RigidWorld();

  RigidState initial_state() const;
  // Mass properties of the bodies. The inertia is about the centre of mass, in mesh axes.
  const std::vector<MassProperties>& mass_properties() const;

  // Builds a new world from `state`, including its manifolds. If these are empty, there are no
  // contact points, and obstacles are at their initial positions. Later results do not depend on
  // any step before this call, except through `state`.
  void restore(const RigidState& state);
  // Applies the impulses, then advances by `step` [s]. `obstacles` gives the obstacles' positions
  // at the end of the step; their velocities are constant over the step. If `touched` (b) is given,
  // it is set to 1 for bodies whose motion was changed by contacts, by the test of surface_guard.h
  // or, with gravity, by rounding, and to 0 for the others.
  // Restitution acts on the approach speed without the velocity changes of this step due to the
  // impulses and to gravity. If the velocities in `state` are those of kick-drift-kick, `half`
  // gives the impulses of a half kick. The approach speed then also excludes the half kick that
  // ended the previous step, and the rebound includes the half kick that ends this step.
  void advance(double step, const BodyImpulses& impulses, const ObstaclePlaces& obstacles,
               RigidState& state, std::vector<std::uint8_t>* touched = nullptr,
               const BodyImpulses* half = nullptr);
  // Returns the work that obstacles did on bodies by their scripted motion in the latest advance()
  // [J].
  double obstacle_work() const;
  // Returns an array (b) that is 1 for bodies with a contact point whose gap is at most Bullet's
  // contact breaking threshold. This threshold is about 1 % of the diagonal of the bounding box of
  // the smaller of the two objects in contact.
  std::vector<std::uint8_t> touching() const;
  // Returns the pairs of bodies, or of a body and an obstacle, that pressed on each other in the
  // step that led to the current state. A pair can occur several times. Indices from the number of
  // bodies on are the obstacles of constant shape, then the triangles of deforming obstacles.
  std::vector<std::array<int, 2>> pressed() const;
  // Returns an array (b) that is 1 for bodies that were pressed against an obstacle, directly or
  // through other bodies, in the step that led to the current state.
  std::vector<std::uint8_t> supported() const;
  // Writes contact manifolds and positions of obstacles to `state.manifolds`, so that restore() can
  // rebuild the world from `state`.
  void save(RigidState& state) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace loomstone
