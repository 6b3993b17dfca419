// A small font of our own, drawn as smooth strokes: digits, small letters, and . - + [ ].
#pragma once

#include <string>

#include "renderer/color_map.h"
#include "renderer/renderer.h"

namespace loomstone {

// Width of a line of text whose figures are `height` high [pixels]. Signs that the font lacks are
// left blank.
double text_width(const std::string& text, double height);
// `left` and `baseline` in pixels from the upper left corner. What lies outside the picture is left
// out.
void draw_text(Image& image, const std::string& text, double left, double baseline, double height,
               const Color& color);

}  // namespace loomstone
