// Functions that build_magnetic_model() and check_magnetic_start() call, in the order of the calls.
// add_magnets() and add_coils() call find_stand().
#pragma once

#include "core/electrodynamics/magnetic_model.h"

namespace loomstone {

void add_magnets(const MagneticScene& scene, MagneticModel& model);
void add_bearings(const MagneticScene& scene, MagneticModel& model);
void add_coils(const MagneticScene& scene, MagneticModel& model);

void check_magnets(const MagneticModel& model, const CarrierPlaces& start);
void check_coils(const MagneticModel& model, const CarrierPlaces& start);

// The carrier of a magnet or coil, and the pose of the magnet or coil on it. find_stand() receives
// this pose in the frame of the carrier's mesh (`in_mesh`). It throws InvalidInput if the name of
// the carrier is empty or unknown, and Unsupported if the carrier deforms.
struct Stand {
  Index carrier = 0;
  RigidPose local;  // see CarriedMagnet::local
};
Stand find_stand(const MagneticScene& scene, const std::string& name, const RigidPose& in_mesh,
                 const std::string& where);

}  // namespace loomstone
