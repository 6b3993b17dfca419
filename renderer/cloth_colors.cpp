#include "renderer/cloth_colors.h"

#include <array>

namespace loomstone {

Eigen::Vector3f cloth_color(std::size_t cloth) {
  using Rgb = Eigen::Vector3f;
  // Our choice.
  static const std::array<Rgb, 6> palette = {Rgb(0.055f, 0.135f, 0.27f), Rgb(0.50f, 0.155f, 0.085f),
                                             Rgb(0.245f, 0.31f, 0.185f), Rgb(0.56f, 0.36f, 0.11f),
                                             Rgb(0.25f, 0.115f, 0.215f), Rgb(0.60f, 0.55f, 0.455f)};
  return palette[cloth % palette.size()];
}

}  // namespace loomstone
