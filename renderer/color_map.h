// Perceptual colour maps: numbers in [0, 1] to colours.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace loomstone {

using Color = std::array<std::uint8_t, 3>;  // sRGB
using ColorTable = std::array<Color, 256>;

const std::vector<std::string>& color_map_names();  // "viridis", "magma", "diverging"
// Throws InvalidInput listing the names.
ColorTable color_table(const std::string& name);

}  // namespace loomstone
