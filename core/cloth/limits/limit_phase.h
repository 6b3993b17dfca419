// Strain limits inside the implicit solve: close to a limit a triangle enters a stiff second phase,
// so that what stops the cloth meets elasticity and contacts in one matrix, and little is left to
// correct afterwards. Our choice; docs/performance.md tells what was tried beside it.
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
  // limit_of (m): row of limits, -1: the triangle has none.
  LimitPhase(Membrane& membrane, const std::vector<StrainLimit>& limits,
             const std::vector<Index>& limit_of);

  // The phase each mode of each triangle that touches rows [begin, end) is in at x; what it adds is
  // linear in the Green strain from there on.
  void enter(const Team& team, const Points& x, Index begin, Index end);
  // See membrane::Tables.
  const double* table() const { return table_.data(); }
  const std::uint8_t* entered() const { return entered_.data(); }

 private:
  Membrane& membrane_;
  AlignedDoubles bounds_;         // (rows x 12 x 8) least, most; those of the third phase
  std::vector<Index> bounds_of_;  // (batches) row of bounds
  AlignedDoubles table_;
  std::vector<std::uint8_t> entered_;
};

}  // namespace loomstone
