// The legend at the right edge: what the colours mean.
#pragma once

#include <string>
#include <vector>

#include "renderer/color_map.h"
#include "renderer/scalar_field.h"

namespace loomstone {

struct ColorBarLabel {
  double share;  // of the bar from its lower end
  std::string text;
};
// Both ends of the range, and round numbers between them.
std::vector<ColorBarLabel> color_bar_labels(const ColorRange& range);

struct ColorBarPlace {
  int left, top, width, height;  // pixels, of the coloured strip
};
ColorBarPlace color_bar_place(int image_width, int image_height);

void draw_color_bar(Image& image, const ColorTable& table, const ColorRange& range,
                    const std::string& title);

}  // namespace loomstone
