#include "core/cloth/limit_potential.h"

#include <algorithm>
#include <cmath>

namespace loomstone {

namespace {

// Modulus that the second phase of the membrane adds (see LimitMode), as a multiple of the modulus
// of the first phase, which is the membrane within its limits. Our choice: with smaller values,
// more stretch remains, and larger values require shorter steps.
constexpr double second_modulus = 30.0;
// Strain at which the third phase begins (see LimitMode), divided by the limit. Our choice. Where
// compression along weft or warp is limited, the third phase begins at a strain of at least -1.
constexpr double third_strain = 1.5;

// Green strain of a line element with the engineering strain e >= -1.
double green(double e) { return e + 0.5 * e * e; }

double bounded(double limit, std::optional<double> bound) {
  return std::isfinite(limit) ? bound.value_or(limit) : limit;
}

void limit_extension(double limit, LimitMode& mode) {
  mode.high = green(limit), mode.far_high = green(third_strain * limit);
}

void limit_compression(double limit, LimitMode& mode) {
  if (limit <= -1.0) return;
  mode.low = green(limit), mode.far_low = green(std::max(-1.0, third_strain * limit));
}

LimitModes element_modes(const StrainLimit& limit, const MembraneConstants& m,
                         std::optional<double> bound) {
  LimitModes modes;
  modes[0].d11 = 1.0, modes[1].d22 = 1.0, modes[2].d12 = 0.5;
  modes[0].modulus = second_modulus * m.a11, modes[1].modulus = second_modulus * m.a22;
  modes[2].modulus = second_modulus * 4.0 * m.g;
  limit_extension(bounded(limit.weft, bound), modes[0]);
  limit_extension(bounded(limit.warp, bound), modes[1]);
  limit_compression(limit.weft_min, modes[0]);
  limit_compression(limit.warp_min, modes[1]);
  // The limit applies to the shear component of the co-rotational strain U - I. If a square is
  // sheared at constant side length, the Green strain E12 equals this component except for terms of
  // third order.
  modes[2].high = bounded(limit.shear, bound);
  modes[2].low = limit.shear_min.value_or(-modes[2].high);
  modes[2].far_high = third_strain * modes[2].high;
  modes[2].far_low = third_strain * modes[2].low;
  return modes;
}

LimitModes edge_modes(const StrainLimit& limit, const MembraneConstants& m, const Corners2& corners,
                      std::optional<double> bound) {
  LimitModes modes;
  for (int k = 0; k < 3; ++k) {
    const Vec2 edge = (corners.row((k + 1) % 3) - corners.row(k)).transpose().normalized();
    const double c = edge.x() * edge.x(), s = edge.y() * edge.y();
    modes[k].d11 = c, modes[k].d22 = s, modes[k].d12 = edge.x() * edge.y();
    limit_extension(bounded(limit.edge_bound(), bound), modes[k]);
    modes[k].modulus =
        second_modulus * (m.a11 * c * c + m.a22 * s * s + (2.0 * m.a12 + 4.0 * m.g) * c * s);
  }
  return modes;
}

}  // namespace

std::vector<LimitModes> limit_potential(const ClothModel& model, std::optional<double> bound) {
  std::vector<LimitModes> modes(model.triangles.rows());
  for (std::size_t t = 0; t < modes.size(); ++t) {
    const Index row = model.strain_limit_of.empty() ? -1 : model.strain_limit_of[t];
    if (row < 0) continue;
    const StrainLimit& limit = model.strain_limits[row];
    modes[t] = model.limited_by_edges || limit.edge
                   ? edge_modes(limit, model.constants_of(t), model.corners[t], bound)
                   : element_modes(limit, model.constants_of(t), bound);
  }
  return modes;
}

}  // namespace loomstone
