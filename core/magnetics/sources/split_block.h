// Splits a block of points by a predicate, so that all lanes of a kernel take the same branch.
// Results are scattered back to the original order.
#pragma once

#include "core/base/simd.h"
#include "core/magnetics/sources/source.h"

namespace loomstone {

// A block of points, and the output arrays of `components` (at most 6) values per point.
struct PointBlock {
  const double* points;
  Index n;
  double* out;
  int components;
};

// first(points, n, out) computes the values at the points where chosen(x, y, z) is true, and
// second(points, n, out) the values at all other points.
template <class Chosen, class First, class Second>
void split_block(PointBlock block, Chosen&& chosen, First&& first, Second&& second) {
  const auto [points, n, out, components] = block;
  Index order[2][points_per_block], count[2] = {0, 0};
  for (Index i = 0; i < n; ++i) {
    const int part = chosen(points[i], points[n + i], points[2 * n + i]) ? 0 : 1;
    order[part][count[part]++] = i;
  }
  if (count[1] == 0) return first(points, n, out);
  if (count[0] == 0) return second(points, n, out);
  for (int part = 0; part < 2; ++part) {
    alignas(64) double x[3 * points_per_block], values[6 * points_per_block];
    const Index m = count[part], padded = (m + n_lanes - 1) / n_lanes * n_lanes;
    for (Index i = 0; i < padded; ++i)
      for (int k = 0; k < 3; ++k)
        x[k * padded + i] = points[k * n + order[part][i < m ? i : m - 1]];
    if (part == 0)
      first(x, padded, values);
    else
      second(x, padded, values);
    for (int c = 0; c < components; ++c)
      for (Index i = 0; i < m; ++i) out[c * n + order[part][i]] = values[c * padded + i];
  }
}

}  // namespace loomstone
