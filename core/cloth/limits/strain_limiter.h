// Corrects positions at which elements exceed their strain limits, and velocities that change
// strain too fast. Implements continuum-based strain limiting, [Thomaszewski2010] chapter 3, and
// edge-based limiting. Every method conserves the linear and angular momentum of free cloth and
// leaves prescribed vertices bitwise unchanged. The result is bitwise identical on any number of
// threads and ranks. The check of all elements is divided among ranks. Every rank performs all
// sweeps, because a divided Gauss-Seidel sweep would need one message per colour.
#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include "core/base/bytes.h"
#include "core/cloth/limits/corotational_strain.h"
#include "core/cloth/limits/limit_check.h"
#include "core/cloth/limits/limit_elements.h"
#include "core/cloth/material/strain_limit.h"
#include "core/parallel/team.h"

namespace loomstone {

class ActiveSet;
class EdgeLimiter;

// Enforces strain limits. `key` and options.seed together determine the order in which random
// sweeps visit the elements. Calls with the same seed and arguments give bitwise identical results.
// On several ranks, all calls are collective.
class StrainLimiter {
 public:
  // The check of all elements is divided among `ranks`; null: a single process.
  StrainLimiter(const LimitedCloth& cloth, const LimitOptions& options,
                const Communicator* ranks = nullptr);
  ~StrainLimiter();

  bool empty() const { return elements_.n_elements() == 0; }
  std::size_t bytes() const {
    return bytes_of(elements_, corrected_, deltas_, order_, n_corrected_);
  }

  // Corrects x. `held` lists vertices that do not move, in addition to the prescribed ones.
  LimitReport enforce(const Team& team, std::uint64_t key, const std::vector<Index>& held,
                      Points& x);

  // Corrects v by sweeps until no strain changes by more than options.strain_rate plus the
  // tolerance in a step of h seconds, or until options.max_sweeps is reached. Does nothing if
  // options.strain_rate is 0. Positions do not change. If `measured` is true, the report contains
  // the excess that remains, as a strain per step. LimitReport::squares, however, contains squared
  // strain rates [1/s^2].
  LimitReport enforce_rate(const Team& team, std::uint64_t key, const Points& x, double h,
                           Points& v, bool measured = true);

  // Reports the excess at x without moving anything.
  LimitReport measure(const Team& team, const Points& x);

 private:
  // Performs sweeps until no element has to be corrected or options.max_sweeps is reached.
  // Returns true if check_ is valid for the result.
  bool sweep_until_met(const Team& team, std::uint64_t key, const limit::Tables& tables,
                       const limit::Motion& motion, LimitReport& report);
  // Each of the next three functions performs one sweep and returns the number of corrected
  // elements.
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
  bool by_elements_ = false;            // true if some cloth is limited by elements
  // Scratch memory.
  std::vector<std::uint8_t> corrected_;  // (batches) bit l is set if lane l was corrected
  std::vector<double> deltas_;
  std::vector<Index> order_;        // slots (8 batch + lane) of all elements, ascending
  std::vector<Index> n_corrected_;  // (n) number of corrected elements at each vertex
};

}  // namespace loomstone
