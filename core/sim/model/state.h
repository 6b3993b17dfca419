// Everything that changes. Together with the model it alone decides the future; a checkpoint holds
// exactly this.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/types.h"
#include "core/cloth/cloth_state.h"
#include "core/collision/model/contact.h"
#include "core/electrodynamics/magnetic_state.h"
#include "core/rigid/rigid_body.h"

namespace loomstone {

// Behind each table stands the stage that writes it. Tables are assigned, never moved into: numpy
// views share their memory.
struct State {
  std::int64_t step = 0;   // steps done; time is step * h; stepper
  ClothState cloth;        // integrate, certify
  RigidState rigid;        // bodies
  MagneticState magnetic;  // bodies
  ContactState contacts;   // certify (anchors of friction)
  std::uint8_t tangled =
      0;  // cloth may intersect something: 1 the user put it so, 2 a step left impacts; check
  Points obstacle_vertices;  // (k x 3) all obstacles end to end, at the present time [m]; stepper
  Points external_force;     // (n x 3) [N], user
  std::vector<std::uint8_t>
      pin_override;   // (n) 1: target set by the user instead of the script; user
  Points pin_target;  // (n x 3) [m], user
  // Pose set by the user instead of keyframes, per obstacle: flag, position, quaternion (w, x, y,
  // z).
  std::vector<std::uint8_t> pose_override;
  Points pose_position;
  Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor> pose_orientation;
};

}  // namespace loomstone
