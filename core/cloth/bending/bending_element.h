// Choice of the bending element of a cloth.
#pragma once

#include <array>

#include "core/base/choice.h"

namespace loomstone {

enum class BendingElement { MidEdge, Hinge };
constexpr auto choices(BendingElement) {
  return std::array{
      ChoiceName{BendingElement::MidEdge, "mid-edge", "beam theory within 1 % along any direction"},
      ChoiceName{BendingElement::Hinge, "hinge",
                 "off by up to 25 % along the axes of grids, 12 to 18 % in strips of 16 to 6 "
                 "elements across on smoothed irregular meshes, a factor 2 at 45 degrees"}};
}

}  // namespace loomstone
