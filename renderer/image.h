// Images, and tables that map values to colours.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace loomstone {

struct Image {
  int width = 0, height = 0, channels = 3;  // channels: 3 (sRGB) or 4 (sRGB, straight alpha)
  std::vector<std::uint8_t> pixels;         // rows from the top, one byte per channel
};

// The surface that is visible at the centre of each pixel. Rows are ordered from the top.
struct SurfaceImages {
  int width = 0, height = 0;
  // Distance from the eye, measured along the viewing direction [m]; infinity: no surface.
  std::vector<float> depth;
  // Unit normal of the visible side, in the world frame, 3 numbers per pixel; zeros: no surface.
  std::vector<float> normal;
  // Number of the surface, or 0 if there is none. Cloths are numbered from 1, followed by bodies
  // and obstacles in the order of the topology. All curves share the number after these.
  std::vector<std::int32_t> id;
};

using Color = std::array<std::uint8_t, 3>;  // sRGB
using ColorTable = std::array<Color, 256>;  // from the low to the high end of a range of values

// Shades of grey from black to white.
ColorTable grey_table();

// Writes a PNG file under a temporary name, then renames it.
void write_png(const std::string& path, const Image& image);

}  // namespace loomstone
