// Which elements are beyond their limits, and by how much. Most of what limiting costs where limits hold: ranks share it, each looks
// at its part of the elements and all learn what was found, the same bits on any number of them.
#pragma once

#include <vector>

#include "core/cloth/limit_elements.h"
#include "core/parallel/communicator.h"
#include "core/parallel/team.h"

namespace loomstone {

struct LimitReport;

// Stage. What it has seen stays until it looks again.
class LimitLook {
 public:
  // ranks: those that share a look, null: one alone.
  LimitLook(const LimitElements& elements, const Communicator* ranks);

  // At all batches. Collective.
  void at_all(const Team& team, const limit::Tables& tables, const limit::Motion& motion);
  // At some of them again, every rank at all of these.
  void at(const Team& team, const limit::Tables& tables, const limit::Motion& motion, const std::vector<Index>& batches);

  // Largest excess of its elements; 0: all are within their bounds.
  double excess(Index batch) const { return excess_[batch]; }
  // (3 x 8) strains, or rates, of a batch with an excess.
  const double* strain(Index batch) const { return strains_.data() + 24 * static_cast<std::size_t>(batch); }

  // Adds to `report` what is beyond; `unit` makes strain of it.
  void tell(const limit::Tables& tables, const limit::Motion& motion, double unit, LimitReport& report) const;

 private:
  void share(Index first, Index last);

  const LimitElements& elements_;
  const Communicator* ranks_;
  std::vector<double> excess_, strains_;     // (batches), (batches x 3 x 8)
};

}  // namespace loomstone
