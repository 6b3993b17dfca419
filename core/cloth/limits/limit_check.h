// Finds the elements that violate their strain limits, and by how much. This check dominates the
// cost when no limit is violated, so its elements are divided among ranks; every rank then learns
// every violation. The result is the same bits on any number of ranks.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "core/cloth/limits/limit_elements.h"
#include "core/parallel/communicator.h"
#include "core/parallel/team.h"

namespace loomstone {

// A mode (weft, warp, shear) of an element that exceeds its limit by more than limit_margin().
struct BrokenLimit {
  Index element;
  int mode;
  double excess;  // strain beyond the limit [1]
};

// The work of limiting and the violations that remain.
struct LimitReport {
  int sweeps = 0;                   // over all elements, or the active ones
  std::int64_t evaluations = 0;     // elements whose strain was computed, summed over ranks
  std::array<double, 3> excess{};   // largest strain beyond its limit in weft, warp, shear [1]
  std::int64_t beyond = 0;          // elements beyond a limit by more than the tolerance
  Index worst = -1;                 // element with the largest excess, -1: no limit is violated
  std::vector<BrokenLimit> broken;  // the largest excess first
  std::vector<double> squares;      // (limits) sum of squares of all excesses

  double largest() const { return std::max({excess[0], excess[1], excess[2]}); }
  std::vector<Index> broken_elements() const;  // ascending, each once
};

// Stage. Keeps what it found until the next check.
class LimitCheck {
 public:
  // ranks: those that share a check; null: this process checks alone.
  LimitCheck(const LimitElements& elements, const Communicator* ranks);

  // Checks all batches. Collective.
  void check_all(const Team& team, const limit::Tables& tables, const limit::Motion& motion);
  // Checks the listed batches again; every rank checks all of them.
  void check(const Team& team, const limit::Tables& tables, const limit::Motion& motion,
             const std::vector<Index>& batches);

  // Largest excess of a batch's elements; 0: all are within their bounds.
  double excess(Index batch) const { return excess_[batch]; }
  // (3 x 8) strains, or rates of strain, of a batch with an excess.
  const double* strain(Index batch) const {
    return strains_.data() + 24 * static_cast<std::size_t>(batch);
  }

  // Adds the violations to `report`; `unit` converts them to strain.
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
