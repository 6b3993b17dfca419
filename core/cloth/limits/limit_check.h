// Finds the elements whose strain or strain rate is outside its bounds, and measures the excess.
// The check of all elements dominates the cost of limiting if no limit is exceeded, so it is
// divided among ranks. Afterwards, every rank has the results of all elements. They are bitwise
// identical on any number of ranks.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "core/cloth/limits/limit_elements.h"
#include "core/parallel/communicator.h"
#include "core/parallel/team.h"

namespace loomstone {

// An element whose strain in one mode (0: weft, 1: warp, 2: shear) exceeds its limit by more than
// limit_margin().
struct BrokenLimit {
  Index element;
  int mode;
  double excess;  // distance of the strain beyond its upper or lower limit [1]
};

// Report on a call of the limiter: its cost and the excess that remains.
struct LimitReport {
  // Number of sweeps. If both elements and edges are swept, the larger of the two numbers. A first
  // check that finds nothing to correct counts as a sweep.
  int sweeps = 0;
  std::int64_t evaluations = 0;     // number of element and edge evaluations before the final check
  std::array<double, 3> excess{};   // largest excess in each mode: weft, warp, shear [1]
  std::int64_t beyond = 0;          // number of elements with an excess above the tolerance
  Index worst = -1;                 // element with the largest excess; -1: no limit is exceeded
  std::vector<BrokenLimit> broken;  // largest excess first
  std::vector<double> squares;      // sum of the squared excesses for each of LimitedCloth::limits

  double largest() const { return std::max({excess[0], excess[1], excess[2]}); }
  std::vector<Index> broken_elements() const;  // in ascending order, without duplicates
};

// Checks elements against their limits and keeps the results until the next check.
class LimitCheck {
 public:
  // check_all() is divided among `ranks`; null: a single process.
  LimitCheck(const LimitElements& elements, const Communicator* ranks);

  // Checks all batches. Collective.
  void check_all(const Team& team, const limit::Tables& tables, const limit::Motion& motion);
  // Rechecks the listed batches. The work is not divided: every rank checks all of these batches.
  void check(const Team& team, const limit::Tables& tables, const limit::Motion& motion,
             const std::vector<Index>& batches);

  // Largest excess among the elements of a batch; 0 if all are within their bounds.
  double excess(Index batch) const { return excess_[batch]; }
  // Strains, or strain rates, of the elements of a batch (3 x 8). Valid only if the batch has an
  // excess.
  const double* strain(Index batch) const {
    return strains_.data() + 24 * static_cast<std::size_t>(batch);
  }

  // Adds the excesses to `report`. For LimitReport::excess, the factor `unit` converts excesses to
  // strains: it is 1 for strains, and the length of the step for strain rates. LimitReport::squares
  // is not converted. LimitReport::broken stays empty for strain rates.
  void add_to(LimitReport& report, const limit::Tables& tables, const limit::Motion& motion,
              double unit) const;

 private:
  limit::Violations violations() { return {excess_.data(), strains_.data()}; }
  void share(Index first, Index last);

  const LimitElements& elements_;
  const Communicator* ranks_;
  std::vector<double> excess_, strains_;  // (batches), (batches x 3 x 8)
};

}  // namespace loomstone
