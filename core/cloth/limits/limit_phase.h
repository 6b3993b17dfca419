// Strain limits inside the implicit solve. Near a limit, a triangle enters a stiff second phase of
// the membrane, and then still stiffer ones. Limits, elasticity and contacts are then solved in one
// linear system, and little remains to be corrected afterwards. This method is not taken from the
// literature; docs/experiments/strain_limits.md compares it with alternatives.
#pragma once

#include <vector>

#include "core/base/bytes.h"
#include "core/base/types.h"
#include "core/cloth/material/strain_limit.h"
#include "core/cloth/membrane/membrane.h"
#include "core/parallel/team.h"

namespace loomstone {

class LimitPhase {
 public:
  // `limit_of` (m) contains indices into `limits`, or -1 for triangles without limits.
  LimitPhase(Membrane& membrane, const std::vector<StrainLimit>& limits,
             const std::vector<Index>& limit_of);

  // Determines the phase that each mode of a triangle is in at positions x, for all triangles that
  // touch rows [begin, end). The stress that the phase adds is linearised in the Green strain at x.
  // In the fourth phase, which begins a little beyond the limit, this stress has a viscous part
  // that limits the recovery of the strain: in one step, the excess decreases by at most about the
  // fraction `recovery`. A triangle yields if yields[v] is not 0 for one of its vertices v: the
  // phases then add only a small stress to the mode that is farthest beyond the upper strain at
  // which its second phase begins. `yields` has an entry for each vertex, or is null. Returns
  // whether any triangle is in a stiff phase.
  bool enter(const Team& team, const Points& x, Index begin, Index end,
             const std::uint8_t* yields = nullptr, double recovery = 1.0);
  // The tables `phase` and `in_phase` of membrane::Tables, which documents their layout.
  const double* table() const { return table_.data(); }
  const std::uint8_t* entered() const { return entered_.data(); }
  std::size_t bytes() const { return bytes_of(bounds_, bounds_of_, table_, entered_); }

 private:
  Membrane& membrane_;
  // (rows x 12 x 8) Strains of the three modes at which stiff phases begin: the lower and then the
  // upper ones of the second phase, followed by those of the third phase. Batches whose lanes have
  // the same limits share a row.
  AlignedDoubles bounds_;
  std::vector<Index> bounds_of_;  // (batches) row of bounds_
  AlignedDoubles table_;
  std::vector<std::uint8_t> entered_;
};

}  // namespace loomstone
