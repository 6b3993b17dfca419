// Strain limits inside the implicit solve: near a limit a triangle enters a stiff second phase of
// the membrane. Limits, elasticity and contacts then meet in one matrix, and little remains to be
// corrected after the solve. Our choice; docs/performance.md compares alternatives.
#pragma once

#include <vector>

#include "core/base/types.h"
#include "core/cloth/material/strain_limit.h"
#include "core/cloth/membrane/membrane.h"
#include "core/parallel/team.h"

namespace loomstone {

// Stage.
class LimitPhase {
 public:
  // limit_of (m): row of limits, -1: unlimited.
  LimitPhase(Membrane& membrane, const std::vector<StrainLimit>& limits,
             const std::vector<Index>& limit_of);

  // Determines the phase of each mode of each triangle that touches rows [begin, end), at x. The
  // stress that the phase adds is linearised there in the Green strain.
  void enter(const Team& team, const Points& x, Index begin, Index end);
  // See membrane::Tables.
  const double* table() const { return table_.data(); }
  const std::uint8_t* entered() const { return entered_.data(); }

 private:
  Membrane& membrane_;
  AlignedDoubles bounds_;         // (rows x 12 x 8) where phases begin: second (least, most), third
  std::vector<Index> bounds_of_;  // (batches) row of bounds
  AlignedDoubles table_;
  std::vector<std::uint8_t> entered_;
};

}  // namespace loomstone
