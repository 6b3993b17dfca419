// Finds pairs of overlapping boxes with Embree.
#pragma once

#include <functional>
#include <vector>

#include "core/collision/broad_phase/slabs.h"

namespace loomstone {

// Calls visit(i, j) for each pair of boxes a[i] and b[j] that overlap along all three coordinate
// axes. May also visit some other pairs. Visits pairs on the calling thread, in no particular
// order. Empty boxes have no pairs.
void embree_pairs(const std::vector<Slabs>& a, const std::vector<Slabs>& b,
                  const std::function<void(Index, Index)>& visit);

}  // namespace loomstone
