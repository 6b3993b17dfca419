#include "core/rigid/contacts/crossing.h"

#include <algorithm>

namespace loomstone {

std::optional<double> crossing(const Vec3& from, const Vec3& to,
                               const std::array<Vec3, 3>& triangle) {
  const std::array<Vec3, 3> arm = {triangle[0] - from, triangle[1] - from, triangle[2] - from};
  const Vec3 normal = (arm[1] - arm[0]).cross(arm[2] - arm[0]), path = to - from;
  const double before = normal.dot(arm[0]), along = normal.dot(path);
  if (along == 0.0 || before * along < 0.0 || std::abs(before) > std::abs(along))
    return std::nullopt;
  // Volumes spanned by the path and each side. If two triangles have a common side, its volume has
  // the same bits for both, up to the sign.
  const double a = arm[0].cross(arm[1]).dot(path), b = arm[1].cross(arm[2]).dot(path),
               c = arm[2].cross(arm[0]).dot(path);
  const bool inside = std::min({a, b, c}) >= 0.0 || std::max({a, b, c}) <= 0.0;
  return inside ? std::optional(before / along) : std::nullopt;
}

}  // namespace loomstone
