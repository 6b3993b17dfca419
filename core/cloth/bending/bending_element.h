// Choice of the bending element of a cloth.
#pragma once

#include <array>

#include "core/base/choice.h"

namespace loomstone {

enum class BendingElement { MidEdge, Hinge };
constexpr auto choices(BendingElement) {
  return std::array{
      ChoiceName{BendingElement::MidEdge, "mid-edge",
                 "agrees with beam theory within 1 % along any direction"},
      ChoiceName{
          BendingElement::Hinge, "hinge",
          "rigidity is wrong by up to 20 % along the axes of grids, by 4 to 17 % on smoothed "
          "irregular meshes, and by a factor of 2 at 45 degrees to a grid"}};
}

}  // namespace loomstone
