// Description of a scene in plain structs. build() checks the description and makes the Model.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "core/base/choice.h"
#include "core/base/field.h"
#include "core/base/types.h"
#include "core/cloth/air.h"
#include "core/cloth/bending/bending_element.h"
#include "core/cloth/material/material.h"
#include "core/cloth/material/strain_limit.h"
#include "core/electrodynamics/bearing.h"
#include "core/electrodynamics/coil.h"
#include "core/electrodynamics/magnet.h"
#include "core/mesh/triangle_mesh.h"
#include "core/rigid/rigid_body.h"

namespace loomstone {

enum class RestLengths { Uv, Mesh };
constexpr auto choices(RestLengths) {
  return std::array{
      ChoiceName{RestLengths::Uv, "uv", "of the pattern: uv are lengths [m]"},
      ChoiceName{RestLengths::Mesh, "mesh", "of the mesh: uv give the directions alone"}};
}
enum class RestAngles { Flat, Mesh };
constexpr auto choices(RestAngles) {
  return std::array{ChoiceName{RestAngles::Flat, "flat"},
                    ChoiceName{RestAngles::Mesh, "mesh", "those of the mesh as given"}};
}

// Description of a cloth.
struct Cloth {
  std::string name;
  std::shared_ptr<const TriangleMesh> mesh;
  ClothMaterial material;
  RestLengths rest = RestLengths::Uv;
  RestAngles rest_angles = RestAngles::Flat;
  BendingElement bending = BendingElement::MidEdge;
  std::vector<Index> pins;           // prescribed vertices: fixed in place, or moved by a script
  std::vector<double> script_times;  // ascending [s]; empty: pins do not move
  // (times * pins x 3) positions of the pins, interpolated linearly [m]
  Points script_positions;
  Points velocities;  // (n x 3) at the start [m/s]; empty: at rest
  double thickness = 0.0;
  double friction = 0.3;
  bool self_collision = true;
  std::optional<StrainLimit> strain_limit;

  static auto fields() {
    using C = Cloth;
    return std::make_tuple(
        field("name", &C::name, "name in reports and files"),
        field("mesh", &C::mesh, "triangle mesh; its vertices are the start positions"),
        field("material", &C::material, "ClothMaterial"), field("rest", &C::rest, "rest lengths"),
        field("rest_angles", &C::rest_angles, "rest angles between triangles"),
        field("bending", &C::bending, "bending element"),
        field("pins", &C::pins, "indices of vertices that are held, or moved by script"),
        field("script_times", &C::script_times,
              "times of the script [s], ascending; empty: pins stand still"),
        field("script_positions", &C::script_positions,
              "(times * pins x 3) positions of the pins [m], linear between"),
        field("velocities", &C::velocities, "(n x 3) at the start [m/s]; empty: at rest"),
        field("thickness", &C::thickness, "m", non_negative(),
              "contact distance; 0: chosen from the mesh"),
        field("friction", &C::friction, "1", non_negative(), "friction coefficient"),
        field("self_collision", &C::self_collision, "the cloth collides with itself"),
        field("strain_limit", &C::strain_limit,
              "StrainLimit: how far it may strain; None: as far as forces take it"));
  }
};

// Description of an obstacle. It is static, moves by keyframes or deforms by a vertex sequence.
struct Obstacle {
  std::string name;
  std::shared_ptr<const TriangleMesh> mesh;
  double friction = 0.3;
  double thickness = 0.0;
  std::vector<double> times;  // of keyframes, ascending [s]
  Points positions;           // (times x 3) positions of the mesh's origin [m]
  Points axis_angles;         // (times x 3) rotation vectors [rad]; empty: no rotation
  Points vertex_positions;    // (times * n x 3) vertex sequence in place of keyframes [m]
  bool floor = false;         // rendered as ground

  static auto fields() {
    using O = Obstacle;
    return std::make_tuple(
        field("name", &O::name, "name in reports and files"),
        field("mesh", &O::mesh, "surface; closed ones refuse cloth that starts inside"),
        field("friction", &O::friction, "1", non_negative(), "friction coefficient"),
        field("thickness", &O::thickness, "m", non_negative(),
              "contact distance; 0: as the cloth's"),
        field("times", &O::times, "times of the keyframes [s], ascending; empty: stands still"),
        field("positions", &O::positions,
              "(times x 3) positions of the mesh's origin [m], linear between"),
        field("axis_angles", &O::axis_angles,
              "(times x 3) rotation vectors [rad], interpolated as rotations"),
        field("vertex_positions", &O::vertex_positions,
              "(times * n x 3) vertex sequence [m], linear between"),
        field("floor", &O::floor, "drawn as ground"));
  }
};

// Two-way coupling that ties cloth vertices to points of a rigid body.
struct Attachment {
  std::string cloth, body;  // names of cloth and body
  std::vector<Index> vertices;

  static auto fields() {
    using A = Attachment;
    return std::make_tuple(
        field("cloth", &A::cloth, "name of the cloth"), field("body", &A::body, "name of the body"),
        field("vertices", &A::vertices, "vertices of the cloth that move with the body"));
  }
};

enum class ContactResponse { Implicit, Impulse };
constexpr auto choices(ContactResponse) {
  return std::array{
      ChoiceName{ContactResponse::Implicit, "implicit", "terms of the implicit solve"},
      ChoiceName{ContactResponse::Impulse, "impulse",
                 "impulses after it, as explicit integrators always do"}};
}

// Description of a whole scene.
struct Scene {
  std::vector<Cloth> cloths;
  std::vector<Obstacle> obstacles;
  std::vector<RigidBody> bodies;
  std::vector<Attachment> attachments;
  std::vector<Magnet> magnets;
  std::vector<Coil> coils;
  std::vector<Bearing> bearings;
  Vec3 magnetic_field = Vec3::Zero();
  double magnetic_tolerance = 1e-4;
  double magnetic_step = 0.15;
  Air air;
  LimitOptions limits;
  Vec3 gravity = Vec3(0, 0, -9.81);
  bool collisions = true;
  double contact_stiffness = 0.0;
  ContactResponse response = ContactResponse::Implicit;
  bool allow_initial_intersections = false;
  int rigid_iterations = RigidWorld::default_iterations;
  int rigid_rebuild_interval = 40;

  static auto fields() {
    using S = Scene;
    return std::make_tuple(
        field("cloths", &S::cloths, "list of Cloth"),
        field("obstacles", &S::obstacles, "list of Obstacle"),
        field("bodies", &S::bodies, "list of RigidBody"),
        field("attachments", &S::attachments, "list of Attachment"),
        field("magnets", &S::magnets, "list of Magnet: what makes bodies and obstacles magnetic"),
        field("coils", &S::coils, "list of Coil: currents on bodies and obstacles"),
        field("bearings", &S::bearings, "list of Bearing: bodies that only turn"),
        field("magnetic_field", &S::magnetic_field,
              "(3) uniform flux density that magnets feel besides one another's [T]"),
        field("magnetic_tolerance", &S::magnetic_tolerance, "1", between(1e-12, 0.1),
              "error of the force between two magnets over the largest such force"),
        field(
            "magnetic_step", &S::magnetic_step, "1", Limits{0.0, 1.0, true, false},
            "length of the sub-steps in which magnets move times their largest angular frequency"),
        field("air", &S::air, "Air: drag and wind"),
        field("limits", &S::limits, "LimitOptions: how strain limits of cloths are enforced"),
        field("gravity", &S::gravity, "acceleration [m/s^2]"),
        field("collisions", &S::collisions, "contacts between surfaces are handled"),
        field("contact_stiffness", &S::contact_stiffness, "N/m", non_negative(),
              "of a contact; 0: chosen from the material"),
        field("response", &S::response, "how contacts act"),
        field("allow_initial_intersections", &S::allow_initial_intersections,
              "accept a start with intersections: they are moved apart, then guarded"),
        field("rigid_iterations", &S::rigid_iterations, "1", between(10, 10000),
              "sweeps of the rigid-body solver over all contacts in a step: stacks want many, "
              "loose heaps few; fewer than 10 feed energy in"),
        field("rigid_rebuild_interval", &S::rigid_rebuild_interval, "1", between(1, 1000),
              "steps between rebuilds of the rigid-body world; checkpoints with bodies fall on "
              "them"));
  }
};

}  // namespace loomstone
