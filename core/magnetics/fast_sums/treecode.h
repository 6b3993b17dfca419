// Sums over many dipoles to a tolerance in a time that grows like N log N: a tree of the dipoles
// and one of the observers, expansions between cells that are far apart beside their sizes, direct
// sums between neighbours [GreengardRokhlin1987], in derivatives of 1/r [Dehnen2002].
//
// The tolerance is the root mean square of the error over that of the result, of the field and of
// what is asked besides. It is controlled: the sums of 128 observers are taken directly as well,
// and where the expansions differ by more the order is raised. Few pairs are summed directly at
// once. The same bits on any number of threads.
//
// Forces between the dipoles of one set are equal and opposite pair of cells by pair of cells. What
// the cut of the expansions leaves of the total angular momentum, less than the tolerance, is taken
// from all torques alike.
#pragma once

#include "core/magnetics/sources/body.h"

namespace loomstone {

// Pairs up to which sums are direct.
inline constexpr double most_direct_pairs = 6e7;

struct TreecodeField {
  Points field;        // (n x 3) B [T]
  Gradients gradient;  // (n x 9) dB_i/dx_j [T/m], empty where it is not wanted
  double error = 0.0;  // as found, relative [1]
  int order = 0;       // of the expansions; 0: direct
};

// Field of the dipoles of `by` at points (n x 3); a dipole at a point adds nothing there. tolerance
// in [1e-10, 0.1].
TreecodeField treecode_field(const Team& team, const DipoleSet& by, const ConstPointsRef& points,
                             bool gradient, double tolerance);

// As dipole_forces(): (6.10) and (6.11) on dipoles by those of `by`.
Wrenches treecode_forces(const Team& team, const Points& positions, const Points& moments,
                         const DipoleSet& by, double tolerance);

}  // namespace loomstone
