// Moves candidate positions so that no element strains beyond its limits: continuum-based strain
// limiting, [Thomaszewski2010] chapter 3, and edge-based limiting for comparison. Every method
// keeps linear and angular momentum; prescribed vertices do not change by one bit. The result is
// the same on any number of threads and ranks. Ranks share the check of all elements; every rank
// computes all sweeps, over the few elements that violate their limits, because a message for each
// colour would take longer.
#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include "core/cloth/limits/corotational_strain.h"
#include "core/cloth/limits/limit_check.h"
#include "core/cloth/limits/limit_elements.h"
#include "core/cloth/material/strain_limit.h"
#include "core/parallel/team.h"

namespace loomstone {

class ActiveSet;
class EdgeLimiter;

// Stage. `key` seeds the random order together with options.seed: calls with the same key, seed and
// positions give the same bits. On several ranks all calls are collective.
class StrainLimiter {
 public:
  // ranks: those that share the check; null: this process works alone.
  StrainLimiter(const LimitedCloth& cloth, const LimitOptions& options,
                const Communicator* ranks = nullptr);
  ~StrainLimiter();

  bool empty() const { return elements_.n_elements() == 0; }

  // Moves x. `held`: vertices that do not move, in addition to the prescribed ones.
  LimitReport enforce(const Team& team, std::uint64_t key, const std::vector<Index>& held,
                      Points& x);

  // Limits the change of strain that velocities cause in a step of h seconds to
  // options.strain_rate; positions stay. If `measured`, the report contains the remaining excess
  // per step.
  LimitReport enforce_rate(const Team& team, std::uint64_t key, const Points& x, double h,
                           Points& v, bool measured = true);

  // Reports the violations at x without moving anything.
  LimitReport measure(const Team& team, const Points& x);

 private:
  // Sweeps until all elements are within their bounds or options.max_sweeps is reached. True if
  // check_ describes the result.
  bool sweep_until_met(const Team& team, std::uint64_t key, const limit::Tables& tables,
                       const limit::Motion& motion, LimitReport& report);
  // One sweep; returns the number of corrected elements.
  std::int64_t sweep(const Team& team, const limit::Tables& tables, const limit::Motion& motion,
                     int number, ActiveSet& active);
  std::int64_t sweep_jacobi(const Team& team, const limit::Tables& tables,
                            const limit::Motion& motion, ActiveSet& active);
  std::int64_t sweep_randomly(const limit::Tables& tables, const limit::Motion& motion,
                              std::uint64_t key, ActiveSet& active);
  void run_batches(const Team& team, const limit::Tables& tables, const limit::Motion& motion,
                   const std::vector<Index>& batches);
  std::int64_t spread(const std::vector<Index>& batches, ActiveSet& active) const;
  std::vector<Index> corners_of(const std::vector<Index>& batches);
  std::vector<Index> by_thread(const Team& team, const std::vector<Index>& batches) const;

  LimitOptions options_;
  LimitElements elements_;
  LimitCheck check_;
  std::unique_ptr<EdgeLimiter> edges_;  // null: no cloth is limited by edges
  bool by_elements_ = false;            // some cloth is limited by elements
  // Scratch.
  std::vector<std::uint8_t> corrected_;  // (batches) bits of lanes
  std::vector<double> deltas_;
  std::vector<Index> order_;        // slots of all elements, not shuffled
  std::vector<Index> n_corrected_;  // (n) elements corrected at each vertex
};

}  // namespace loomstone
