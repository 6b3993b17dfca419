// Ways to divide the searches for contacts and impacts among ranks (Decomposition) and among the
// threads of a rank (Traversal). They do not affect results.
#pragma once

#include <array>

#include "core/base/choice.h"

namespace loomstone {

enum class Decomposition { Predicted, Static, Dynamic };
constexpr auto choices(Decomposition) {
  return std::array{
      ChoiceName{Decomposition::Predicted, "predicted",
                 "neighbour lists that are kept over several steps"},
      ChoiceName{Decomposition::Static, "static",
                 "traversal in every step; ranks share the pairs of partitions evenly"},
      ChoiceName{Decomposition::Dynamic, "dynamic",
                 "traversal in every step; idle ranks take work from busy ones"}};
}

// Loops: the traversal begins on one thread, and a parallel loop over its branches continues it.
// Tasks: idle threads take branches from busy ones throughout.
enum class Traversal { Loops, Tasks };
constexpr auto choices(Traversal) {
  return std::array{
      ChoiceName{Traversal::Loops, "loops", "a parallel loop over branches of the traversal"},
      ChoiceName{Traversal::Tasks, "tasks", "idle threads take branches from busy ones"}};
}

}  // namespace loomstone
