// Treecode for sums over many dipoles, to a tolerance, in a time that grows like N log N: a
// dual-tree fast multipole method [GreengardRokhlin1987] with Cartesian Taylor expansions
// [Dehnen2002]. Cells that are far apart relative to their sizes interact by expansions,
// neighbouring leaves directly.
//
// The error is the root mean square over observers relative to that of the result; field and
// gradient, or forces and torques, must both meet the tolerance. It is measured: 128 observers are
// summed directly too, and the order is raised while they differ by more. Few pairs are summed
// directly. The result has the same bits on any number of threads.
//
// Forces between the dipoles of one set are equal and opposite, cell pair by cell pair. Truncation
// leaves a total torque below the tolerance, which is subtracted from all torques in equal parts.
#pragma once

#include "core/magnetics/sources/body.h"

namespace loomstone {

// Largest number of pairs that is summed directly.
inline constexpr double most_direct_pairs = 6e7;

struct TreecodeField {
  Points field;        // (n x 3) B [T]
  Gradients gradient;  // (n x 9) dB_i/dx_j [T/m], empty where it is not wanted
  double error = 0.0;  // measured, relative [1]
  int order = 0;       // of the expansions; 0: direct sum
};

// Field of the dipoles of `by` at points (n x 3); a dipole located at a point contributes nothing
// there. tolerance in [1e-10, 0.1].
TreecodeField treecode_field(const Team& team, const DipoleSet& by, const ConstPointsRef& points,
                             bool gradient, double tolerance);

// Forces (6.10) and torques (6.11) on dipoles by those of `by`, as dipole_forces().
Wrenches treecode_forces(const Team& team, const Points& positions, const Points& moments,
                         const DipoleSet& by, double tolerance);

}  // namespace loomstone
