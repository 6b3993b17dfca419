// Merges sorted runs, such as the sorted results of several ranks.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/parallel/shared_work.h"

namespace loomstone {

// Sorts `elements`, which is a sequence of sorted runs. Run i begins at starts[i]; the last entry
// of `starts` is the number of elements. Elements that are equal keep their order.
template <class Element, class Before>
void merge_runs(std::vector<Element>& elements, std::vector<std::size_t> starts, Before before) {
  std::vector<Element> merged(elements.size());
  const auto at = [](std::vector<Element>& of, std::size_t i) {
    return of.begin() + static_cast<std::ptrdiff_t>(i);
  };
  while (starts.size() > 2) {
    std::vector<std::size_t> joined;
    for (std::size_t run = 0; run + 1 < starts.size(); run += 2) {
      joined.push_back(starts[run]);
      const std::size_t middle = starts[run + 1],
                        end = starts[std::min(run + 2, starts.size() - 1)];
      std::merge(at(elements, starts[run]), at(elements, middle), at(elements, middle),
                 at(elements, end), at(merged, starts[run]), before);
    }
    joined.push_back(starts.back());
    elements.swap(merged);
    starts = std::move(joined);
  }
}

// Returns the starts of the ascending runs in `elements`, followed by the number of elements.
template <class Element>
std::vector<std::size_t> ascending_runs(const std::vector<Element>& elements) {
  std::vector<std::size_t> starts = {0};
  for (auto end = elements.begin(); end != elements.end();) {
    end = std::is_sorted_until(end, elements.end());
    starts.push_back(static_cast<std::size_t>(end - elements.begin()));
  }
  return starts;
}

// An element, and a number that determines its place among other elements.
template <class Element>
struct Placed {
  std::uint64_t place;
  const Element* element;
};

inline constexpr auto by_place = [](const auto& a, const auto& b) { return a.place < b.place; };

// Returns copies of the elements that `order` lists, in this order.
template <class Element>
std::vector<Element> copies(const std::vector<Placed<Element>>& order) {
  std::vector<Element> copied;
  copied.reserve(order.size());
  for (const Placed<Element>& each : order) copied.push_back(*each.element);
  return copied;
}

// Returns the elements of all ranks in ascending order of `place_of(element)`. The elements of
// each rank must already be in this order.
template <class Element, class PlaceOf>
std::vector<Element> merged(Gathered<Element> all, PlaceOf place_of) {
  if (all.start.size() <= 2) return std::move(all.elements);
  std::vector<Placed<Element>> order;
  order.reserve(all.elements.size());
  for (const Element& element : all.elements) order.push_back({place_of(element), &element});
  merge_runs(order, all.start, by_place);
  return copies(order);
}

}  // namespace loomstone
