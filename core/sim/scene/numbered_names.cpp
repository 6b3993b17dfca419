#include "core/sim/scene/numbered_names.h"

#include <algorithm>
#include <cctype>
#include <set>

namespace loomstone {

namespace {

// Returns a name without the number at its end, for example "sphere" for "sphere_2".
std::string without_number(const std::string& name) {
  const std::size_t bar = name.rfind('_');
  if (bar == std::string::npos || bar == 0 || bar + 1 == name.size()) return name;
  const bool number = std::all_of(name.begin() + static_cast<std::ptrdiff_t>(bar) + 1, name.end(),
                                  [](unsigned char letter) { return std::isdigit(letter); });
  return number ? name.substr(0, bar) : name;
}

}  // namespace

void number_names(Scene& scene) {
  std::set<std::string> taken;
  for (const auto& cloth : scene.cloths) taken.insert(cloth.name);
  for (const auto& body : scene.bodies) taken.insert(body.name);
  for (const auto& obstacle : scene.obstacles)
    if (!obstacle.numbered) taken.insert(obstacle.name);
  for (auto& obstacle : scene.obstacles) {
    if (!obstacle.numbered || obstacle.name.empty()) continue;
    const std::string base = without_number(obstacle.name);
    for (int number = 2; !taken.insert(obstacle.name).second; ++number)
      obstacle.name = base + "_" + std::to_string(number);
  }
}

}  // namespace loomstone
