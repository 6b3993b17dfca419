// Colour legend at the right edge of the picture.
#pragma once

#include <string>
#include <vector>

#include "renderer/color_map.h"
#include "renderer/scalar_field.h"

namespace loomstone {

struct ColorBarLabel {
  double share;  // position along the bar: 0 at its lower end, 1 at its upper end
  std::string text;
};
// Labels at both ends of the range and at round numbers between them.
std::vector<ColorBarLabel> color_bar_labels(const ColorRange& range);

struct ColorBarPlace {
  int left, top, width, height;  // of the coloured strip [pixels]
};
ColorBarPlace color_bar_place(int image_width, int image_height);

void draw_color_bar(Image& image, const ColorTable& table, const ColorRange& range,
                    const std::string& title);

}  // namespace loomstone
