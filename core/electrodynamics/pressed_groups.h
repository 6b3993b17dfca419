// Groups of bodies that press on each other.
#pragma once

#include <array>
#include <vector>

#include "core/electrodynamics/magnetic_model.h"

namespace loomstone {

// Bodies that press on each other, directly or through others of the group.
struct PressedGroup {
  std::vector<Index> bodies;  // at least two, ascending
  bool on_obstacle = false;   // true: one of them presses on an obstacle or on a body in a bearing
};
// Returns the groups of bodies without bearings that are connected by pairs that press on each
// other (see RigidWorld::pressed).
std::vector<PressedGroup> pressed_groups(const MagneticModel& model,
                                         const std::vector<std::array<int, 2>>& pressed);

}  // namespace loomstone
