// Bounds on the approach of two features whose velocities may change within a step.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "core/collision/model/contact.h"

namespace loomstone {

// Allowance for velocities that change within a step. Our choice: two features are assumed to
// approach by no more than 1.5 times their speed of approach times the time, plus the smaller of
// 0.3 m/s times the time and half of 120 m/s^2 times the square of the time. These two terms are
// equal after 5 ms. Pairs that approach faster are left to certification.
inline constexpr double faster_approach = 1.5, added_approach = 0.3, added_acceleration = 120.0;

// Returns the largest speed at which a corner of feature a approaches a corner of feature b along
// the contact normal [m/s]. At constant velocities, the distance along the normal decreases at most
// at this speed. `speeds` are the velocity components [m/s] of the four vertices along the normal,
// which points from b to a.
inline double largest_approach(ContactKind kind, const std::array<double, 4>& speeds) {
  if (kind == ContactKind::VertexFace)
    return std::max({speeds[1], speeds[2], speeds[3]}) - speeds[0];
  return std::max(speeds[2], speeds[3]) - std::min(speeds[0], speeds[1]);
}
// Returns the largest distance [m] by which the gap of a pair may shrink within `time` if its
// initial speed of approach is `approach`.
inline double largest_loss(double approach, double time) {  // [m/s], [s]
  const double added = std::min(added_approach * time, 0.5 * added_acceleration * time * time);
  return faster_approach * std::max(0.0, approach) * time + added;
}
// Returns the shortest time [s] in which a pair may close its gap if its initial speed of approach
// is `approach`: the time for which largest_loss() equals `gap`, or 0 if `gap` is not positive.
inline double time_to_close(double gap, double approach) {  // [m], [m/s]
  const double speed = faster_approach * std::max(0.0, approach);
  if (gap > (speed + added_approach) * (2.0 * added_approach / added_acceleration))
    return gap / (speed + added_approach);
  return gap > 0.0 ? 2.0 * gap / (speed + std::sqrt(speed * speed + 2.0 * added_acceleration * gap))
                   : 0.0;
}

}  // namespace loomstone
