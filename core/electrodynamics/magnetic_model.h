// Model of the magnetic part of a scene: magnets, coils and bearings on bodies and obstacles,
// validated and converted to tables. Constant once built.
#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/electrodynamics/bearing.h"
#include "core/electrodynamics/carriers.h"
#include "core/electrodynamics/coil.h"
#include "core/electrodynamics/magnet.h"
#include "core/magnetics/induction/soft_shape.h"
#include "core/rigid/free_motion.h"
#include "core/rigid/rigid_body.h"

namespace loomstone {

// A body or obstacle that may carry magnets and coils. A body may also have a bearing.
struct MagneticCarrier {
  std::string name;
  std::shared_ptr<const TriangleMesh> mesh;
  MassProperties mass;                  // bodies only
  Vec4 orientation = Vec4(1, 0, 0, 0);  // orientation at the start, bodies only
  bool deforms = false;                 // true: an obstacle that deforms
};

// Input from which a MagneticModel is built.
struct MagneticScene {
  std::vector<Magnet> magnets;
  std::vector<Coil> coils;
  std::vector<Bearing> bearings;
  std::vector<MagneticCarrier> carriers;  // bodies, then obstacles
  Index n_bodies = 0;
  Vec3 gravity = Vec3::Zero();  // [m/s^2]
  Vec3 field = Vec3::Zero();    // uniform flux density [T]
  double tolerance = 1e-4;      // tolerated force error, relative to the largest force [1]
  // Limit of sub-step length times angular frequency, and of sub-step length times rate of relative
  // motion [1].
  double substep = 0.15;
};

// A magnet on its carrier.
struct CarriedMagnet {
  SourcePtr source;                           // null: induced magnet
  double radius = 0.0, polarizability = 0.0;  // [m], [A m^2/T]; induced spheres only
  SoftShapePtr soft;        // shape of an induced body; null: a point dipole or a hard magnet
  double saturation = 0.0;  // saturation polarization of `soft` [T]; 0: none
  // (n x 3) Positions of the cells of an explicit response (Magnet::response), in the frame of the
  // magnet [m]; empty for the mutual response.
  Points cells;
  // Pose in mesh axes. It is relative to the centre of mass if the carrier is a body, and to the
  // origin of the mesh if it is an obstacle.
  RigidPose local;
  Index carrier = 0;  // body index, or number of bodies plus obstacle index
};

// A coil on its carrier.
struct CarriedCoil {
  Coil coil;
  SourcePtr source;  // carries one ampere
  RigidPose local;   // see CarriedMagnet::local
  Index carrier = 0;

  bool circuit() const { return coil.resistance > 0.0; }  // false: given current
  // Returns false for a given current without `times`. Such a current is constant, so the flux of
  // magnetised bodies through the coil has no effect.
  bool wants_flux() const { return circuit() || !coil.times.empty(); }
};

// Properties of a rigid body that determine its motion under magnetic forces.
struct MagneticRotor {
  MassProperties mass;
  Rotor rotor;
  std::optional<Bearing> bearing;  // its axis is a unit vector
};

// Result of build_magnetic_model().
struct MagneticModel {
  Vec3 gravity = Vec3::Zero(), field = Vec3::Zero();  // [m/s^2], [T]
  double tolerance = 1e-4, substep = 0.15;            // see MagneticScene
  std::vector<CarriedMagnet> magnets;
  std::vector<CarriedCoil> coils;
  // Indices of the coils with given currents, and of the coils in circuits.
  std::vector<std::size_t> given, circuits;
  std::vector<MagneticRotor> bodies;
  Index n_obstacles = 0;

  Index n_bodies() const { return static_cast<Index>(bodies.size()); }
  bool acts() const;  // whether the scene has magnets, coils or bearings
  BearingAxes bearing_axes() const;
  // Returns the carrier index of a body, and the common index n_bodies() for all obstacles. Forces
  // between obstacles are not needed, because forces do not move obstacles.
  Index group(Index carrier) const { return std::min(carrier, n_bodies()); }
};

// Validates the scene and builds its model. Throws InvalidInput or Unsupported.
MagneticModel build_magnetic_model(const MagneticScene& scene);

// Throws InvalidInput if one of these holds at the start: a magnetisable body overlaps another one,
// a magnet or a winding; two circuits are loops that coincide; the inductance matrix of several
// circuits is not positive definite.
// Throws Unsupported if, in a scene with circuits, a magnetisable body lies both in the bore and
// outside the winding of a coil with wants_flux(). Spheres treated as point dipoles are checked
// for overlap with windings only.
void check_magnetic_start(const MagneticModel& model, const CarrierPlaces& start);

// Returns the coordinate of `point` along the moment of a hard magnet on the carrier, relative to
// the position of the magnet and divided by the radius of the magnet's bounding sphere. `point` is
// given in the same frame as CarriedMagnet::local. Magnets with zero moment do not count. The
// function chooses the magnet with the smallest ratio of distance to this radius. The result is
// positive on the side of the north pole and negative on the side of the south pole. It is 0 if all
// ratios are at least 1.3. Dipoles without extent have the ratio 1 at any distance.
double pole_at(const MagneticModel& model, Index carrier, const Vec3& point);

}  // namespace loomstone
