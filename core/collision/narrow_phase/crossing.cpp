#include "core/collision/narrow_phase/crossing.h"

#include <algorithm>
#include <cmath>

namespace loomstone {

// Let r be the vector between points of the two edges a and b at the parameters s and t. Let f and
// g be the products r . a and r . b. Assume that, after a relative motion of at most m, the closest
// points are interior and closer than `thickness`. Then f and g vanish at these points after the
// motion. Before it, at the same s and t, |f| was at most m (|a| + 2 thickness): the motion changes
// r by at most m and a by at most 2 m, and |r| is less than `thickness` after it. Likewise, |g| was
// at most m (|b| + 2 thickness). Both products are linear in s and t. So are the two linear
// combinations of f and g from which t or s cancels. For each of these four functions, the smallest
// magnitude for s and t in [0, 1] gives a lower bound on m.
double motion_to_cross(const FourPoints& p, double thickness) {
  const Vec3 a = p[1] - p[0], b = p[3] - p[2], r = p[0] - p[2];
  const double aa = a.squaredNorm(), bb = b.squaredNorm(), ab = a.dot(b), ra = r.dot(a),
               rb = r.dot(b), determinant = aa * bb - ab * ab;
  const double f_per_m = std::sqrt(aa) + 2.0 * thickness, g_per_m = std::sqrt(bb) + 2.0 * thickness;
  const auto bound = [](double least, double most, double per_m) {
    return std::max(least, -most) / per_m;
  };
  const double of_f = bound(ra + std::min(0.0, -ab), ra + aa + std::max(0.0, -ab), f_per_m);
  const double of_g = bound(rb - bb + std::min(0.0, ab), rb + std::max(0.0, ab), g_per_m);
  const double of_s = bound(bb * ra - ab * rb, bb * ra - ab * rb + determinant,
                            bb * f_per_m + std::abs(ab) * g_per_m);
  const double of_t = bound(ab * ra - aa * rb, ab * ra - aa * rb + determinant,
                            std::abs(ab) * f_per_m + aa * g_per_m);
  return std::max({0.0, of_f, of_g, of_s, of_t});
}

}  // namespace loomstone
