#include "renderer/surface_colors.h"

#include <array>
#include <cmath>

namespace loomstone {

using Rgb = Eigen::Vector3f;

Rgb cloth_color(std::size_t cloth) {
  // Front colours of the first cloths in linear RGB. Further cloths repeat them.
  static const std::array<Rgb, 6> palette = {Rgb(0.055f, 0.135f, 0.27f), Rgb(0.50f, 0.155f, 0.085f),
                                             Rgb(0.245f, 0.31f, 0.185f), Rgb(0.56f, 0.36f, 0.11f),
                                             Rgb(0.25f, 0.115f, 0.215f), Rgb(0.60f, 0.55f, 0.455f)};
  return palette[cloth % palette.size()];
}

Rgb body_color(std::size_t body) {
  return Rgb(0.46f, 0.45f, 0.44f) * (1.0f - 0.07f * static_cast<float>(body % 3));
}

Rgb shown_color(const Look& look, const Rgb& otherwise) {
  if (!look.color) return otherwise;
  return look.color
      ->unaryExpr(
          [](double c) { return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4); })
      .cast<float>();
}

}  // namespace loomstone
