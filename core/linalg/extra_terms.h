// Terms that couple a few rows in an implicit solve, in addition to the fixed elastic pattern:
// contacts, friction, untangling, attachments. A term depends on one relative velocity
// u = sum_i J_i v_i - drift (3-vector). Its energy E depends on the relative displacement s, the
// time integral of u. Let g be dE/ds at the start of the step or, if the term is evaluated after a
// motion of the rows, at the end of this motion. Let H be d2E/ds2 or a positive semi-definite
// replacement. Row i gets the force -J_i^T g, and block (i, j) of the stiffness gets J_i^T H J_j.
// Rows 0 to n - 1 are cloth vertices. Body b has row n + 2b for translation of its centre and row
// n + 2b + 1 for rotation about it.
#pragma once

#include <array>
#include <vector>

#include "core/base/types.h"

namespace loomstone {

struct TermEntry {
  Index row = -1;
  // For a translation, J v = weight v. For a rotation, J omega = weight (omega x arm).
  bool rotation = false;
  double weight = 0.0;  // [1]
  // For a rotation: point of the body relative to its centre, in world axes [m].
  Vec3 arm = Vec3::Zero();

  Vec3 apply(const Vec3& row_velocity) const {  // returns J v
    return rotation ? Vec3(weight * row_velocity.cross(arm)) : Vec3(weight * row_velocity);
  }
  Vec3 apply_transposed(const Vec3& force) const {  // returns J^T force
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
  std::array<TermEntry, 8> entries;  // sorted by row
  int n_entries = 0;
  Vec3 gradient = Vec3::Zero();  // g [N]
  Mat3 hessian = Mat3::Zero();   // H [N/m], symmetric positive semi-definite
  Vec3 drift = Vec3::Zero();     // minus the weighted sum of obstacle velocities [m/s]

  // Returns the relative displacement s [m] at `time` [s] after the start of the step, for the
  // given displacement of the rows (rows x 3) [m, rad].
  Vec3 relative_displacement(const Points& displacement, double time) const {
    Vec3 d = -time * drift;
    for (int e = 0; e < n_entries; ++e)
      d += entries[e].apply(displacement.row(entries[e].row).transpose());
    return d;
  }
  // Updates the gradient from the start of the step to `time` [s] after it, at constant H, for the
  // given displacement of the rows. Returns the resulting change of the energy [J].
  double move_linearly(const Points& displacement, double time) {
    const Vec3 d = relative_displacement(displacement, time), start = gradient;
    gradient += hessian * d;
    return 0.5 * (start + gradient).dot(d);
  }
};

// Ways to evaluate terms after the rows have moved. Derivative: the gradient and H are derivatives
// of the potential. Secant: like Derivative, but the friction in H is the curvature of a paraboloid
// that touches the potential of friction from above. NewLimits: like Derivative, but first sets the
// friction limits to the friction coefficients times the normal forces after the motion. These
// limits stay constant until the next NewLimits request, so that the terms have a potential.
enum class TermRequest { Derivative, Secant, NewLimits };

// Terms of contacts are sorted by (kind, a, b) of their Contact (core/collision/model/contact.h).
using ExtraTerms = std::vector<ExtraTerm>;

}  // namespace loomstone
