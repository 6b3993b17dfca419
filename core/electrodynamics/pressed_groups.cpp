#include "core/electrodynamics/pressed_groups.h"

#include <algorithm>
#include <numeric>

namespace loomstone {

std::vector<PressedGroup> pressed_groups(const MagneticModel& model,
                                         const std::vector<std::array<int, 2>>& pressed) {
  const auto n = static_cast<int>(model.n_bodies());
  const auto moves = [&](int body) { return body < n && !model.bodies[body].bearing; };
  std::vector<int> root(n);
  std::iota(root.begin(), root.end(), 0);
  const auto root_of = [&](int body) {
    while (root[body] != body) body = root[body];
    return body;
  };
  for (const auto& [a, b] : pressed) {
    if (!moves(a) || !moves(b)) continue;
    const int first = root_of(a), second = root_of(b);
    root[std::max(first, second)] = std::min(first, second);
  }
  std::vector<PressedGroup> groups(n);
  for (int body = 0; body < n; ++body) groups[root_of(body)].bodies.push_back(body);
  for (const auto& [a, b] : pressed)
    if (moves(a) != moves(b)) groups[root_of(moves(a) ? a : b)].on_obstacle = true;
  std::erase_if(groups, [](const PressedGroup& group) { return group.bodies.size() < 2; });
  return groups;
}

}  // namespace loomstone
