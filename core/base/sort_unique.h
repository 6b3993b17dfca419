// Sorting with removal of duplicates.
#pragma once

#include <algorithm>
#include <vector>

namespace loomstone {

// Sorts elements and removes duplicates.
template <class Element>
void sort_unique(std::vector<Element>& elements) {
  std::sort(elements.begin(), elements.end());
  elements.erase(std::unique(elements.begin(), elements.end()), elements.end());
}

}  // namespace loomstone
