// Steps that are nested in a common interval. A step of level k is the interval divided by a base
// number and by 2^k. Every event of a level is also an event of all finer levels, and every level
// has an event at both ends of the interval.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

#include "core/base/types.h"

namespace loomstone {

inline constexpr int finest_level = 16;

// Returns the coarsest level whose step, interval / (base 2^level), is at most `longest`. Returns
// finest_level + 1 if no level up to finest_level has such a step.
int level_below(double interval, Index base, double longest);

// Tries up to 1000 base numbers. Returns the one with which the events of an interval take the
// least computing time in total, by estimate. `membrane` (m) and `bending` (m, or empty) contain
// the longest step of each triangle [s].
Index choose_base(double interval, const Vector& membrane, const Vector& bending);

// Integrates one interval by kicks and drifts. `finest` is the finest level in use. The system has
// the functions
//   measure(first, start)    computes the forces of the levels >= first; `start`: at the
//                            start of the interval
//   kick(first, half)        applies the impulses of these forces over the steps of their levels;
//                            `half`: half the impulses
//   drift(first, tick)       moves each vertex whose finest level is >= first for one step of its
//                            finest level; `tick`: number of steps of the level `finest` since the
//                            start of the interval
// If forces depend on positions only, the half kicks at both ends make the scheme symmetric in time
// and of order 2.
template <class System>
void take_nested_steps(Index base, int finest, System& system) {
  const Index n_ticks = base * (Index{1} << finest);
  for (Index tick = 0; tick <= n_ticks; ++tick) {
    const int twos = tick == 0 || tick == n_ticks
                         ? finest
                         : std::min(finest, std::countr_zero(static_cast<std::uint32_t>(tick)));
    const bool end = tick == 0 || tick == n_ticks;
    system.measure(finest - twos, tick == 0);
    system.kick(finest - twos, end);
    if (tick < n_ticks) system.drift(finest - twos, tick);
  }
}

}  // namespace loomstone
