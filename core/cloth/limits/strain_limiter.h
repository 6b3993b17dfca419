// Moves candidate positions so that no element strains beyond its limits: continuum-based strain
// limiting, [Thomaszewski2010] chapter 3, and edge-based limiting for comparison. Every method
// keeps linear and angular momentum; vertices that are fixed do not change by one bit. The result
// is the same on any number of threads and ranks. Ranks share the looks at all elements; the
// sweeps, over the few elements that looks have found, they all compute, since a message for each
// colour would take longer.
#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include "core/cloth/limits/limit_check.h"
#include "core/cloth/limits/limit_elements.h"
#include "core/cloth/material/strain_limit.h"
#include "core/parallel/team.h"

namespace loomstone {

// U - I = (weft, warp, shear e12) from the Green strain of the same triangle.
Vec3 corotational_strain(const Vec3& green);

// U - I of a triangle, and of every triangle (m x 3), in its weft/warp axes: weft, warp, shear e12
// [1].
Vec3 corotational_strain(const Triangles& triangles, const std::vector<Corners2>& corners,
                         const Points& x, Index triangle);
void corotational_strain(const Team& team, const Triangles& triangles,
                         const std::vector<Corners2>& corners, const Points& x, Points& strain);

class EdgeLimiter;

// Stage. `key` of the random order: calls of the same key, seed and positions give the same bits.
// On several ranks all calls are collective.
class StrainLimiter {
 public:
  // ranks: that share the work; null: one alone.
  StrainLimiter(const LimitedCloth& cloth, const LimitOptions& options,
                const Communicator* ranks = nullptr);
  ~StrainLimiter();

  bool empty() const { return elements_.n_elements() == 0; }

  // Moves x. `held`: vertices that stay where they are besides those that are fixed.
  LimitReport enforce(const Team& team, std::uint64_t key, const std::vector<Index>& held,
                      Points& x);

  // Limits what velocities change of strain in a step of h seconds to options.strain_rate;
  // positions stay. The excess is per step, and measured only on demand.
  LimitReport enforce_rate(const Team& team, std::uint64_t key, const Points& x, double h,
                           Points& v, bool measured = true);

  // The excess at x; nothing moves.
  LimitReport measure(const Team& team, const Points& x);

 private:
  class Pending;
  // Sweeps until all is within its bounds, or too many. True where what the look has seen still is
  // so.
  bool enforce(const Team& team, std::uint64_t key, const limit::Tables& tables,
               const limit::Motion& motion, LimitReport& report);
  std::int64_t sweep(const Team& team, const limit::Tables& tables, const limit::Motion& motion,
                     int number, Pending& pending);
  std::int64_t sweep_jacobi(const Team& team, const limit::Tables& tables,
                            const limit::Motion& motion, Pending& pending);
  std::int64_t sweep_randomly(const limit::Tables& tables, const limit::Motion& motion,
                              std::uint64_t key, Pending& pending);
  void run_batches(const Team& team, const limit::Tables& tables, const limit::Motion& motion,
                   const std::vector<Index>& batches);
  std::int64_t spread(const std::vector<Index>& batches, Pending& pending) const;
  std::vector<Index> corners_of(const std::vector<Index>& batches);
  std::vector<Index> divided(const Team& team, const std::vector<Index>& batches) const;

  LimitOptions options_;
  LimitElements elements_;
  LimitLook look_;
  std::unique_ptr<EdgeLimiter> edges_;  // of the cloths that are limited by edges
  bool by_elements_ = false;            // others are there
  // Scratch.
  std::vector<std::uint8_t> corrected_;  // (batches) bits of lanes
  std::vector<double> deltas_;
  std::vector<Index> order_;        // slots of all elements, before they are shuffled
  std::vector<Index> n_corrected_;  // (n) elements corrected at each vertex
};

}  // namespace loomstone
