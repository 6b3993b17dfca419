// Perceptual colour maps from [0, 1] to sRGB.
#pragma once

#include <array>
#include <cstdint>

#include "core/base/choice.h"

namespace loomstone {

using Color = std::array<std::uint8_t, 3>;  // sRGB
using ColorTable = std::array<Color, 256>;

enum class ColorMap { Viridis, Magma, Diverging };
constexpr auto choices(ColorMap) {
  return std::array{ChoiceName{ColorMap::Viridis, "viridis"}, ChoiceName{ColorMap::Magma, "magma"},
                    ChoiceName{ColorMap::Diverging, "diverging", "blue to red"}};
}

ColorTable color_table(ColorMap map);

}  // namespace loomstone
