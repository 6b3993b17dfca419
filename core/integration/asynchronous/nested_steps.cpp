#include "core/integration/asynchronous/nested_steps.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace loomstone {

int level_below(double interval, Index base, double longest) {
  double step = interval / static_cast<double>(base);
  int level = 0;
  while (step > longest && level <= finest_level) step *= 0.5, ++level;
  return level;
}

namespace {
double count_events(double interval, Index base, const Vector& longest) {
  double events = 0.0;
  for (const double step : longest) events += std::ldexp(base, level_below(interval, base, step));
  return events;
}
}  // namespace

Index choose_base(double interval, const Vector& membrane, const Vector& bending) {
  // Rough ratio of the computing time of a triangle's bending force to that of its membrane force.
  constexpr double bending_cost = 2.5;
  // Base 2 b gives the same steps as base b, except for the longest step of base b. Large bases are
  // therefore not tried: the largest one is twice the number of steps in the interval of the
  // triangle with the longest membrane step, but at least 16 and at most 1000.
  constexpr double fewest_tried = 16.0, most_tried = 1000.0;
  const double steps = 2.0 * std::ceil(interval / membrane.maxCoeff());
  const auto last = static_cast<Index>(std::clamp(steps, fewest_tried, most_tried));
  Index best = 1;
  double least = std::numeric_limits<double>::infinity();
  for (Index base = 1; base <= last; ++base) {
    const double cost = count_events(interval, base, membrane) +
                        bending_cost * count_events(interval, base, bending);
    if (cost < least) least = cost, best = base;
  }
  return best;
}

}  // namespace loomstone
