// Lookup of keyframes by time.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace loomstone {

// Indices of the two keyframes that enclose a time, and the fraction of their interval that has
// passed at that time. At or before the first keyframe, both indices refer to the first keyframe.
// At or after the last keyframe, both refer to the last keyframe. In both cases, `fraction` is 0.
struct Keyframes {
  std::size_t first, second;
  double fraction;
};

inline Keyframes keyframes_at(const std::vector<double>& times, double time) {
  if (time <= times.front()) return {0, 0, 0.0};
  if (time >= times.back()) return {times.size() - 1, times.size() - 1, 0.0};
  const std::size_t next = std::upper_bound(times.begin(), times.end(), time) - times.begin();
  return {next - 1, next, (time - times[next - 1]) / (times[next] - times[next - 1])};
}

}  // namespace loomstone
