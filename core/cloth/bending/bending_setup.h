// Shared by the two bending elements: checks, rest angles, highest frequency.
#pragma once

#include <functional>
#include <vector>

#include "core/cloth/bending/bending.h"
#include "core/cloth/bending/hinge.h"

namespace loomstone {

// Throws InvalidInput if sizes differ, a triangle has no rest area, a number is not finite, a
// rigidity is not positive semi-definite, or damping is negative.
void check_bending_setup(const BendingSetup& setup);

// Hinges of the setup with their rest angles. Throws InvalidInput for a wrong number of rest
// angles.
HingeSet make_hinge_set(const BendingSetup& setup, const EdgeTable& edges);

// 0, 1, ..., n - 1
std::vector<Index> all_of(Index n);

// Largest eigenvalue of M^-1 K by power iteration. moments(values, out) computes Q times the rates
// in `values`, one entry per hinge. Prescribed rows do not move.
double power_iteration(const HingeSet& hinges, const Points& rest_positions,
                       const std::vector<std::uint8_t>& prescribed, const Vector& mass,
                       const std::function<void(const HingeValues&, AlignedDoubles&)>& moments);

}  // namespace loomstone
