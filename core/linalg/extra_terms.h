// Terms of few rows that join the fixed elastic pattern in an implicit solve: contacts, friction,
// attachments. A term sees one 3-vector u = sum_i J_i v_i - drift (a relative velocity);
// displacements h u change its energy. With g = dE/du' and H = d2E/du'2 at the start of the step
// (u' the displacement), row i gets the force -J_i^T g and block (i, j) of the stiffness gets J_i^T
// H J_j. Block rows 0..n-1 are cloth vertices; body b has row n + 2b (translation of its centre)
// and n + 2b + 1 (rotation about it).
#pragma once

#include <array>
#include <vector>

#include "core/base/types.h"

namespace loomstone {

struct TermEntry {
  Index row = -1;
  bool rotation =
      false;  // false: J = weight I; true: J = -weight [arm]x, so that J omega = weight omega x arm
  double weight = 0.0;      // [1]
  Vec3 arm = Vec3::Zero();  // point of the body relative to its centre [m]

  Vec3 apply(const Vec3& row_velocity) const {  // J v
    return rotation ? Vec3(weight * row_velocity.cross(arm)) : Vec3(weight * row_velocity);
  }
  Vec3 apply_transposed(const Vec3& force) const {  // J^T f
    return rotation ? Vec3(weight * arm.cross(force)) : Vec3(weight * force);
  }
  Mat3 jacobian() const {
    if (!rotation) return weight * Mat3::Identity();
    Mat3 j;
    j << 0, arm.z(), -arm.y(), -arm.z(), 0, arm.x(), arm.y(), -arm.x(), 0;
    return weight * j;
  }
};

struct ExtraTerm {
  std::array<TermEntry, 8> entries;  // rows ascending
  int n_entries = 0;
  Vec3 gradient = Vec3::Zero();  // g [N]
  Mat3 hessian = Mat3::Zero();   // H [N/m], symmetric PSD
  Vec3 drift = Vec3::Zero();     // prescribed velocity (scripted motion), in u [m/s]

  // u' [m] `time` after the start, where the rows have moved by `displacement` (rows x 3).
  Vec3 relative_displacement(const Points& displacement, double time) const {
    Vec3 d = -time * drift;
    for (int e = 0; e < n_entries; ++e)
      d += entries[e].apply(displacement.row(entries[e].row).transpose());
    return d;
  }
  // Gradient there of a term whose H does not change; returns the energy above that of the start
  // [J].
  double move_linearly(const Points& displacement, double time) {
    const Vec3 d = relative_displacement(displacement, time), start = gradient;
    gradient += hessian * d;
    return 0.5 * (start + gradient).dot(d);
  }
};

// Which gradient and H are wanted where rows have moved. The limits of friction are those of the
// last request of NewLimits, at first those of the start; between such requests the terms have a
// potential, and H is its second derivative. Secant: H of the paraboloid that touches the potential
// from above, with which steps are never too long.
enum class TermRequest { Derivative, Secant, NewLimits };

using ExtraTerms = std::vector<ExtraTerm>;  // sorted by (kind, a, b) of what they came from

}  // namespace loomstone
