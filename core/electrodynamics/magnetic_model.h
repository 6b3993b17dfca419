// The magnetic part of a scene, checked and turned into tables: magnets, coils and bearings on
// bodies and obstacles. Constant once built.
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

// Description. A body or an obstacle on which magnets, coils and bearings may stand.
struct MagneticCarrier {
  std::string name;
  std::shared_ptr<const TriangleMesh> mesh;
  MassProperties mass;                  // of a body
  Vec4 orientation = Vec4(1, 0, 0, 0);  // of a body at the start
  bool deforms = false;                 // an obstacle that does not keep its shape
};

// Description. All that a MagneticModel is built from.
struct MagneticScene {
  std::vector<Magnet> magnets;
  std::vector<Coil> coils;
  std::vector<Bearing> bearings;
  std::vector<MagneticCarrier> carriers;  // bodies, then obstacles
  Index n_bodies = 0;
  Vec3 gravity = Vec3::Zero();  // [m/s^2]
  Vec3 field = Vec3::Zero();    // uniform flux density [T]
  double tolerance = 1e-4;      // error of the force between two magnets over the largest such [1]
  double substep = 0.15;        // length of a sub-step times the largest angular frequency [1]
};

// A magnet on its carrier.
struct CarriedMagnet {
  SourcePtr source;                           // none: induced
  double radius = 0.0, polarizability = 0.0;  // of an induced sphere [m], [A m^2/T]
  SoftShapePtr soft;        // of induced bodies, unless all are spheres taken as point dipoles
  double saturation = 0.0;  // of it [T]
  Points cells;             // where it answers explicitly [m]
  RigidPose local;          // body: from its centre; obstacle: from the mesh's origin; mesh axes
  Index carrier = 0;        // body, or number of bodies plus obstacle
};

// A coil on its carrier.
struct CarriedCoil {
  Coil coil;
  SourcePtr source;  // with one ampere
  RigidPose local;   // as of magnets
  Index carrier = 0;

  bool circuit() const { return coil.resistance > 0.0; }  // else its current is given
  // Whether anything follows from the flux of magnetised bodies through it.
  bool wants_flux() const { return circuit() || !coil.times.empty(); }
};

// A body as magnetic forces move it.
struct MagneticRotor {
  MassProperties mass;
  Rotor rotor;
  std::optional<Bearing> bearing;  // its axis of unit length
};

// Model.
struct MagneticModel {
  Vec3 gravity = Vec3::Zero(), field = Vec3::Zero();  // [m/s^2], [T]
  double tolerance = 1e-4, substep = 0.15;            // as of MagneticScene
  std::vector<CarriedMagnet> magnets;
  std::vector<CarriedCoil> coils;
  std::vector<std::size_t> given, circuits;  // places of the coils with given currents, of circuits
  std::vector<MagneticRotor> bodies;
  Index n_obstacles = 0;

  Index n_bodies() const { return static_cast<Index>(bodies.size()); }
  bool acts() const;  // on bodies
  // The carrier, with one number for all obstacles: what stands on them does not move apart.
  Index group(Index carrier) const { return std::min(carrier, n_bodies()); }
};

// Checks the descriptions. Throws InvalidInput and Unsupported.
MagneticModel build_magnetic_model(const MagneticScene& scene);

// Refuses a start at which bodies that magnetise overlap with magnets or windings, and circuits
// whose inductances cannot be.
void check_magnetic_start(const MagneticModel& model, const CarrierPlaces& start);

// How far north a point of the carrier [m] is in its nearest magnet, -1 ... 1 along the moment; 0
// away from hard magnets.
double pole_at(const MagneticModel& model, Index carrier, const Vec3& point);

}  // namespace loomstone
