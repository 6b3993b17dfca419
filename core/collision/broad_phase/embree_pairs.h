// Pairs of overlapping boxes by Embree.
#pragma once

#include <functional>
#include <vector>

#include "core/collision/broad_phase/slabs.h"

namespace loomstone {

// Calls visit(i, j), in any order and on one thread, for each pair of a[i] and b[j] whose axis
// slabs overlap, and for some other pairs. Empty slabs have no pairs.
void embree_pairs(const std::vector<Slabs>& a, const std::vector<Slabs>& b,
                  const std::function<void(Index, Index)>& visit);

}  // namespace loomstone
