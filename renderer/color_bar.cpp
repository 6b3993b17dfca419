// Draws the colour bar onto the finished picture, so that lighting does not change its colours.
#include "renderer/color_bar.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "renderer/stroke_font.h"

namespace loomstone {
namespace {

const Color ink = {38, 40, 44};

double text_height(int image_height) { return std::max(7.0, 0.0185 * image_height); }

std::string number(double value, int decimals, double span) {
  char text[40];
  if (decimals > 5 || span >= 1e5)
    std::snprintf(text, sizeof text, "%.3g", value);
  else
    std::snprintf(text, sizeof text, "%.*f", decimals, value == 0.0 ? 0.0 : value);
  return text;
}

void fill(Image& image, int left, int top, int width, int height, const Color& color) {
  for (int y = std::max(0, top); y < std::min(image.height, top + height); ++y)
    for (int x = std::max(0, left); x < std::min(image.width, left + width); ++x)
      std::copy(color.begin(), color.end(),
                &image.rgb[3 * (static_cast<std::size_t>(y) * image.width + x)]);
}

}  // namespace

std::vector<ColorBarLabel> color_bar_labels(const ColorRange& range) {
  const double span = range.high - range.low;
  const double power = std::pow(10.0, std::floor(std::log10(span / 4.0)));
  double step = 10.0 * power;
  for (double factor : {1.0, 2.0, 5.0})
    if (span / (factor * power) <= 5.0) {
      step = factor * power;
      break;
    }
  const int decimals = std::max(0, static_cast<int>(std::ceil(-std::log10(step) - 1e-9)));
  const int end_decimals =
      std::max(decimals, static_cast<int>(std::ceil(-std::log10(span) + 2.0 - 1e-9)));
  const auto end_text = [&](double value) {
    const bool round = std::abs(value / step - std::round(value / step)) < 1e-6;
    return number(value, round ? decimals : end_decimals, span);
  };
  std::vector<ColorBarLabel> labels = {{0.0, end_text(range.low)}};
  for (double tick = std::ceil(range.low / step) * step; tick < range.high; tick += step) {
    const double share = (tick - range.low) / span;
    if (share > 0.09 && share < 0.91)
      labels.push_back({share, number(std::abs(tick) < 1e-9 * step ? 0.0 : tick, decimals, span)});
  }
  labels.push_back({1.0, end_text(range.high)});
  return labels;
}

ColorBarPlace color_bar_place(int image_width, int image_height) {
  const double text = text_height(image_height);
  const int height = std::max(2, static_cast<int>(0.42 * image_height));
  const int width = std::max(2, static_cast<int>(1.25 * text));
  return {std::max(0, static_cast<int>(image_width - 8.0 * text)), (image_height - height) / 2,
          width, height};
}

void draw_color_bar(Image& image, const ColorTable& table, const ColorRange& range,
                    const std::string& title) {
  const ColorBarPlace place = color_bar_place(image.width, image.height);
  const double text = text_height(image.height);
  fill(image, place.left - 1, place.top - 1, place.width + 2, place.height + 2, ink);
  for (int row = 0; row < place.height; ++row) {
    const double share =
        place.height > 1 ? 1.0 - static_cast<double>(row) / (place.height - 1) : 0.0;
    fill(image, place.left, place.top + row, place.width, 1,
         table[static_cast<std::size_t>(std::lround(255.0 * share))]);
  }
  const int tick = std::max(2, static_cast<int>(0.35 * text));
  for (const ColorBarLabel& label : color_bar_labels(range)) {
    const double y = place.top + (1.0 - label.share) * (place.height - 1);
    fill(image, place.left + place.width + 1, static_cast<int>(std::lround(y)), tick, 1, ink);
    draw_text(image, label.text, place.left + place.width + tick + 0.5 * text, y + 0.5 + 0.5 * text,
              text, ink);
  }
  const double right = image.width - 1.2 * text;
  const double left = std::max(2.0, std::min(place.left - 1.0, right - text_width(title, text)));
  draw_text(image, title, left, place.top - 1.1 * text, text, ink);
}

}  // namespace loomstone
