// Which elements are beyond their limits, and by how much. Most of what limiting costs where limits
// hold: ranks share it, each looks at its part of the elements and all learn what was found, the
// same bits on any number of them.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "core/cloth/limits/limit_elements.h"
#include "core/parallel/communicator.h"
#include "core/parallel/team.h"

namespace loomstone {

// A mode (weft, warp, shear) of an element that is beyond its limit by more than limit_margin().
struct BrokenLimit {
  Index element;
  int mode;
  double excess;  // strain beyond the limit [1]
};

// What limiting did, and what it left.
struct LimitReport {
  int sweeps = 0;                   // over all elements, or the active ones
  std::int64_t evaluations = 0;     // elements whose strain was computed, by all ranks together
  std::array<double, 3> excess{};   // largest strain beyond its limit in weft, warp, shear [1]
  std::int64_t beyond = 0;          // elements beyond a limit by more than the tolerance
  Index worst = -1;                 // the element most beyond its limits, -1 where none is
  std::vector<BrokenLimit> broken;  // the largest excess first
  std::vector<double> squares;      // (limits) sums over all excess

  double largest() const { return std::max({excess[0], excess[1], excess[2]}); }
  std::vector<Index> broken_elements() const;  // ascending, each once
};

// Stage. What it has seen stays until it looks again.
class LimitLook {
 public:
  // ranks: those that share a look, null: one alone.
  LimitLook(const LimitElements& elements, const Communicator* ranks);

  // At all batches. Collective.
  void at_all(const Team& team, const limit::Tables& tables, const limit::Motion& motion);
  // At some of them again, every rank at all of these.
  void at(const Team& team, const limit::Tables& tables, const limit::Motion& motion,
          const std::vector<Index>& batches);

  // Largest excess of its elements; 0: all are within their bounds.
  double excess(Index batch) const { return excess_[batch]; }
  // (3 x 8) strains, or rates, of a batch with an excess.
  const double* strain(Index batch) const {
    return strains_.data() + 24 * static_cast<std::size_t>(batch);
  }

  // Adds to `report` what is beyond; `unit` makes strain of it.
  void tell(const limit::Tables& tables, const limit::Motion& motion, double unit,
            LimitReport& report) const;

 private:
  void share(Index first, Index last);

  const LimitElements& elements_;
  const Communicator* ranks_;
  std::vector<double> excess_, strains_;  // (batches), (batches x 3 x 8)
};

}  // namespace loomstone
