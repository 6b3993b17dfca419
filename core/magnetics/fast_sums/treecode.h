// Treecode for sums over N dipoles to a given tolerance in O(N log N) time. It is a dual-tree fast
// multipole method [GreengardRokhlin1987] with Cartesian Taylor expansions [Dehnen2002]. Cells that
// are far apart relative to their sizes interact by expansions. Neighbouring leaves interact
// directly.
//
// The relative error is the root mean square of the error over observers, divided by the root mean
// square of the result. Field and gradient (if requested), or forces and torques, must both meet
// the tolerance. The error is measured at up to 128 observers, for which the sum is also computed
// directly. More accurate expansions are tried until the error meets the tolerance. If there are
// few pairs (see most_direct_pairs) or no expansion suffices, all pairs are summed directly. The
// result is bit-identical for any number of threads.
//
// Forces between the dipoles of one set are equal and opposite for each pair of cells. Truncation
// leaves a small total torque, which is subtracted in equal parts from all torques.
#pragma once

#include "core/magnetics/sources/body.h"

namespace loomstone {

// Up to this number of pairs of an observer and a dipole, all pairs are summed directly.
inline constexpr double most_direct_pairs = 6e7;

struct TreecodeField {
  Points field;        // (n x 3) B [T]
  Gradients gradient;  // (n x 9) dB_i/dx_j [T/m], empty if not requested
  double error = 0.0;  // measured relative error [1], 0 for a direct sum
  int order = 0;       // order of the expansions, 0 for a direct sum
};

// Returns the field of the dipoles of `by` at points (n x 3), its gradient if `gradient` is true,
// and the error and order of the result. A dipole at the position of a point contributes nothing
// there. `tolerance` must be in [1e-10, 0.1].
TreecodeField treecode_field(const Team& team, const DipoleSet& by, const ConstPointsRef& points,
                             bool gradient, double tolerance);

// Returns the forces (6.10) and torques (6.11) of [Thomaszewski2010] that the dipoles of `by` exert
// on the given dipoles, and the energies of these dipoles, as dipole_forces() does.
// `tolerance` must be in [1e-10, 0.1].
Wrenches treecode_forces(const Team& team, const Points& positions, const Points& moments,
                         const DipoleSet& by, double tolerance);

}  // namespace loomstone
