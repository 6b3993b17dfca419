// Description of a scene in plain structs. build() checks the description and makes the Model.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/choice.h"
#include "core/base/field.h"
#include "core/base/look.h"
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
      ChoiceName{RestLengths::Uv, "uv", "lengths of the pattern: uv in metres [m]"},
      ChoiceName{RestLengths::Mesh, "mesh", "lengths of the mesh: uv give only the directions"}};
}
enum class RestAngles { Flat, Mesh };
constexpr auto choices(RestAngles) {
  return std::array{ChoiceName{RestAngles::Flat, "flat"},
                    ChoiceName{RestAngles::Mesh, "mesh", "those of the mesh"}};
}

// Description of a cloth.
struct Cloth {
  std::string name;
  std::shared_ptr<const TriangleMesh> mesh;
  ClothMaterial material;
  RestLengths rest = RestLengths::Uv;
  RestAngles rest_angles = RestAngles::Flat;
  BendingElement bending = BendingElement::MidEdge;
  std::vector<Index> pins;           // prescribed vertices: pinned in place, or moved by a script
  std::vector<double> script_times;  // ascending [s]; empty: no script
  // (times * pins x 3) positions of the pins, interpolated linearly [m]
  Points script_positions;
  Points velocities;  // (n x 3) velocities at the start [m/s]; empty: at rest
  double thickness = 0.0;
  double friction = 0.3;
  bool self_collision = true;
  std::optional<StrainLimit> strain_limit;
  std::optional<Look> look;

  static auto fields() {
    using C = Cloth;
    return std::make_tuple(
        field("name", &C::name, "name in reports and files"),
        field("mesh", &C::mesh, "triangle mesh; its vertices are the start positions"),
        field("material", &C::material, "ClothMaterial"), field("rest", &C::rest, "rest lengths"),
        field("rest_angles", &C::rest_angles, "rest angles between triangles"),
        field("bending", &C::bending, "bending element"),
        field("pins", &C::pins, "indices of prescribed vertices: at rest, or moved by a script"),
        field("script_times", &C::script_times,
              "times of the script [s], ascending; empty: pins at rest"),
        field("script_positions", &C::script_positions,
              "(times x pins x 3) or (times * pins x 3) positions of the pins [m], linearly "
              "interpolated"),
        field("velocities", &C::velocities, "(n x 3) initial velocities [m/s]; by default at rest"),
        field("thickness", &C::thickness, "m", non_negative(),
              "distance at which the cloth touches itself; two surfaces touch at the mean of their "
              "thicknesses; 0: chosen from the mesh"),
        field("friction", &C::friction, "1", non_negative(), "friction coefficient"),
        field("self_collision", &C::self_collision, "whether the cloth collides with itself"),
        field("strain_limit", &C::strain_limit,
              "StrainLimit: bounds on its strain; None: no bounds"),
        field("look", &C::look,
              "Look: its colour and texture in pictures; None: the renderer's default"));
  }
};

// Description of an obstacle. It is static, moves by keyframes or deforms by `vertex_positions`.
struct Obstacle {
  std::string name;
  bool numbered = false;  // a number is appended to its name if another surface has this name
  std::shared_ptr<const TriangleMesh> mesh;
  double friction = 0.3;
  double thickness = 0.0;
  std::vector<double> times;  // times of keyframes or vertex_positions, ascending [s]
  Points positions;           // (times x 3) positions of the mesh's origin [m]; empty: zero
  Points axis_angles;         // (times x 3) rotation vectors [rad]; empty: no rotation
  Points vertex_positions;    // (times * n x 3) vertex positions [m], in place of keyframes
  bool floor = false;         // rendered as ground
  std::optional<Look> look;

  static auto fields() {
    using O = Obstacle;
    return std::make_tuple(
        field("name", &O::name, "name in reports and files"),
        field("numbered", &O::numbered,
              "whether a scene appends a number to the name, as in sphere_2, if another surface "
              "has it"),
        field("mesh", &O::mesh, "surface; cloth must start outside a closed one"),
        field("friction", &O::friction, "1", non_negative(), "friction coefficient"),
        field("thickness", &O::thickness, "m", non_negative(),
              "thickness; cloth touches it at the mean of both thicknesses; 0: the largest of the "
              "cloths, or 1 mm without cloth"),
        field("times", &O::times, "times of the keyframes [s], ascending; empty: at rest"),
        field("positions", &O::positions,
              "(times x 3) positions of the mesh's origin [m], linearly interpolated"),
        field("axis_angles", &O::axis_angles,
              "(times x 3) rotation vectors [rad], interpolated as rotations"),
        field("vertex_positions", &O::vertex_positions,
              "(times x n x 3) or (times * n x 3) vertex positions instead of keyframes [m], "
              "linearly interpolated"),
        field("floor", &O::floor, "whether it is drawn as ground"),
        field("look", &O::look,
              "Look: its colour and texture in pictures; None: the renderer's default"));
  }
};

// Two-way coupling of cloth vertices with points of a rigid body.
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
                 "impulses after the solve; explicit integrators always use them"}};
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
        field("magnets", &S::magnets, "list of Magnet: magnets on bodies and obstacles"),
        field("coils", &S::coils, "list of Coil: coils on bodies and obstacles"),
        field("bearings", &S::bearings, "list of Bearing: axes about which bodies turn"),
        field("magnetic_field", &S::magnetic_field, "(3) external uniform flux density [T]"),
        field(
            "magnetic_tolerance", &S::magnetic_tolerance, "1", between(1e-12, 0.1),
            "largest error of the force between two magnets, relative to the larger of the largest "
            "such force and their own torque / radius"),
        field("magnetic_step", &S::magnetic_step, "1", Limits{0.0, 1.0, true, false},
              "largest product of the length of a magnetic sub-step and the angular frequency of "
              "the magnets' oscillations or the rate of their relative motion"),
        field("air", &S::air, "Air: drag and wind"),
        field("limits", &S::limits, "LimitOptions: enforcement of strain limits"),
        field("gravity", &S::gravity, "acceleration of gravity [m/s^2]"),
        field("collisions", &S::collisions,
              "whether cloth collides; bodies always collide with each other and with obstacles"),
        field("contact_stiffness", &S::contact_stiffness, "N/m", non_negative(),
              "stiffness of a contact; 0: chosen from the material"),
        field("response", &S::response, "contact response"),
        field("allow_initial_intersections", &S::allow_initial_intersections,
              "whether surfaces may intersect at the start; untangling then moves them apart"),
        field("rigid_iterations", &S::rigid_iterations, "1", between(10, 10000),
              "sweeps of the rigid-body solver over all contacts per step; stacks need more than "
              "loose heaps, and fewer than 10 add energy"),
        field("rigid_rebuild_interval", &S::rigid_rebuild_interval, "1", between(1, 1000),
              "steps between rebuilds of the rigid-body world; with bodies, checkpoints are taken "
              "only at a rebuild"));
  }
};

}  // namespace loomstone
