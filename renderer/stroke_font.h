// A small built-in font of smooth strokes: digits, lower-case letters and . - + / [ ].
#pragma once

#include <string>

#include "renderer/color_map.h"
#include "renderer/renderer.h"

namespace loomstone {

// Width of a line of text with digits of the given height [pixels]. Characters that the font lacks
// are drawn as blanks.
double text_width(const std::string& text, double height);
// Draws a line of text. `left` and `baseline` are distances from the upper left corner of the
// picture [pixels]. Text is clipped to the picture.
void draw_text(Image& image, const std::string& text, double left, double baseline, double height,
               const Color& color);

}  // namespace loomstone
