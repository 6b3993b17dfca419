// Functions that both bending elements use.
#pragma once

#include <functional>
#include <vector>

#include "core/cloth/bending/bending.h"
#include "core/cloth/bending/hinge.h"

namespace loomstone {

// Throws InvalidInput if an array (other than rest_angles) has a wrong size, the rest area of a
// triangle is at most 1e-12 times the square of its longest edge, a rigidity is not a finite,
// symmetric and positive semi-definite matrix, a damping is negative or not finite, or a rest angle
// is outside (-pi, pi).
void check_bending_setup(const BendingSetup& setup);

// Creates the hinges of the setup with their rest angles. Throws InvalidInput if the number of rest
// angles is wrong.
HingeSet make_hinge_set(const BendingSetup& setup, const EdgeTable& edges);

// Returns 0, 1, ..., n - 1.
std::vector<Index> all_of(Index n);

// Returns the largest eigenvalue of M^-1 K at the rest positions [1/s^2], slightly underestimated
// by power iteration. M is the mass matrix, and K is the bending stiffness. moments(values, out)
// must set `out` to A r with the angular rates r of the hinges (values.rate) and the matrix A of
// the derivatives of the hinge moments with respect to the hinge angles. Prescribed vertices do not
// move.
double power_iteration(const HingeSet& hinges, const Points& rest_positions,
                       const std::vector<std::uint8_t>& prescribed, const Vector& mass,
                       const std::function<void(const HingeValues&, AlignedDoubles&)>& moments);

}  // namespace loomstone
