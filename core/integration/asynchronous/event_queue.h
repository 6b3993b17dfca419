// Events of elements that have steps of their own, in the order of their times, as in algorithm 4.1
// of [Thomaszewski2010]. The times to the next events can be kept from one interval to the next.
#pragma once

#include <algorithm>
#include <functional>
#include <utility>
#include <vector>

#include "core/base/types.h"

namespace loomstone {

// Integrates over one interval of length `interval` [s]. `clocks` (elements x 2) contains, for each
// element, the time since its last event and the time until its next event [s]. Both times refer to
// the start of the interval on entry, and to its end on return. Events at the same time are handled
// in ascending order of elements. The queue is a binary heap. `Elements` has the functions
//   step(element)            returns the time from an event to the next [s]
//   move(element, time)      advances the vertices of the element to `time`, which is counted from
//                            the start of the interval [s]
//   kick(element, duration)  applies the impulse of the element's force over `duration`, the time
//                            since its last event
template <class Elements>
void take_events(double interval, Elements& elements, Points2& clocks) {
  using Event = std::pair<double, Index>;  // time and element
  std::vector<Event> heap;
  for (Index e = 0; e < clocks.rows(); ++e)
    if (clocks(e, 1) <= interval) heap.emplace_back(clocks(e, 1), e);
  std::make_heap(heap.begin(), heap.end(), std::greater<>());
  clocks.col(0) *= -1.0;  // both columns are now times from the start of the interval
  while (!heap.empty()) {
    std::pop_heap(heap.begin(), heap.end(), std::greater<>());
    const auto [time, element] = heap.back();
    heap.pop_back();
    elements.move(element, time);
    elements.kick(element, time - clocks(element, 0));
    clocks(element, 0) = time;
    clocks(element, 1) = time + elements.step(element);
    if (clocks(element, 1) > interval) continue;
    heap.emplace_back(clocks(element, 1), element);
    std::push_heap(heap.begin(), heap.end(), std::greater<>());
  }
  clocks.col(0) = interval - clocks.col(0).array();
  clocks.col(1).array() -= interval;
}

}  // namespace loomstone
