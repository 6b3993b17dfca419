// The complete state of a simulation. Model and State alone determine all later steps. A checkpoint
// contains the entire State.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/types.h"
#include "core/cloth/cloth_state.h"
#include "core/collision/model/contact.h"
#include "core/electrodynamics/magnetic_state.h"
#include "core/rigid/rigid_body.h"

namespace loomstone {

// Each comment ends with the stage that writes the table. Tables are assigned, never moved into,
// because numpy views share their memory.
struct State {
  std::int64_t step = 0;   // completed steps, time = step * h; stepper
  ClothState cloth;        // integrate, certify
  RigidState rigid;        // bodies
  MagneticState magnetic;  // bodies
  ContactState contacts;   // certify (anchors of friction)
  // 0: no intersections. 1: the user's positions may intersect. 2: a step left impacts. Written
  // by the check.
  std::uint8_t tangled = 0;
  Points obstacle_vertices;  // (k x 3) vertices of all obstacles at the current time [m]; stepper
  Points external_force;     // (n x 3) [N], user
  // (n) 1: target set by the user in place of the script; user
  std::vector<std::uint8_t> pin_override;
  Points pin_target;  // (n x 3) [m], user
  // Poses set by the user in place of keyframes, one per obstacle: flag, position [m], quaternion
  // (w, x, y, z).
  std::vector<std::uint8_t> pose_override;
  Points pose_position;
  Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor> pose_orientation;
};

}  // namespace loomstone
