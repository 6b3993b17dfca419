#include "core/cloth/bending/hinge.h"

#include <algorithm>
#include <cstring>
#include <numeric>

#include "core/base/simd.h"
#include "core/base/sort_unique.h"
#include "core/cloth/bending/hinge_kernels.h"

namespace loomstone {

HingeSet::HingeSet(Index n_vertices, std::vector<Hinge> hinges, std::vector<double> rest_angles)
    : hinges_(std::move(hinges)), rest_angles_(std::move(rest_angles)) {
  vertices_.resize(static_cast<std::size_t>(n_batches()) * hinge::vertex_stride);
  rest_lanes_.resize(static_cast<std::size_t>(n_batches()) * hinge::angle_stride);
  for (Index e = 0; e < n_batches() * n_lanes; ++e) {
    const Index source = std::min(e, n_hinges() - 1);  // unused lanes repeat the last hinge
    const std::size_t batch = e / n_lanes, lane = e % n_lanes;
    for (int j = 0; j < 4; ++j)
      vertices_[hinge::vertex_stride * batch + n_lanes * j + lane] = hinges_[source].vertices[j];
    rest_lanes_[e] = rest_angles_[source];
  }
  of_vertices_.start.assign(n_vertices + 1, 0);
  for (const Hinge& h : hinges_)
    for (const Index vertex : h.vertices) ++of_vertices_.start[vertex + 1];
  std::partial_sum(of_vertices_.start.begin(), of_vertices_.start.end(),
                   of_vertices_.start.begin());
  of_vertices_.items.resize(of_vertices_.start[n_vertices]);
  std::vector<Index> fill(of_vertices_.start.begin(), of_vertices_.start.end() - 1);
  for (Index e = 0; e < n_hinges(); ++e)
    for (int j = 0; j < 4; ++j) of_vertices_.items[fill[hinges_[e].vertices[j]]++] = 4 * e + j;
  for (Index i = 0; i < n_vertices; ++i) {
    if (of_vertices_.start[i] == of_vertices_.start[i + 1]) continue;
    if (runs_.empty() || runs_.back()[1] != i) runs_.push_back({i, i});
    runs_.back()[1] = i + 1, ++n_kept_;
  }
}

// Returns whether `kept` is bitwise equal to the positions x of the vertices with hinges.
bool HingeSet::keeps(const Points& x, const Points& kept) const {
  if (kept.rows() != n_kept_) return false;
  const double* next = kept.data();
  for (const auto& [begin, end] : runs_) {
    const std::size_t size = 3 * static_cast<std::size_t>(end - begin);
    if (std::memcmp(next, x.row(begin).data(), sizeof(double) * size) != 0) return false;
    next += size;
  }
  return true;
}

void HingeSet::keep(const Points& x, Points& kept) const {
  kept.resize(n_kept_, 3);
  Index next = 0;
  for (const auto& [begin, end] : runs_) {
    kept.middleRows(next, end - begin) = x.middleRows(begin, end - begin);
    next += end - begin;
  }
}

void HingeSet::find_range(Index begin, Index end, HingeRange& range) const {
  if (begin == range.begin && end == range.end) return;
  range.begin = begin, range.end = end;
  range.batches.clear(), range.hinges.clear(), range.places.clear();
  range.chunk_start.assign(1, 0);
  for (Index first = begin; first < end; first += rows_per_block) {
    const Index last = std::min(end, first + rows_per_block);
    const auto item = of_vertices_.items.begin();
    for (auto k = item + of_vertices_.start[first]; k < item + of_vertices_.start[last]; ++k)
      range.hinges.push_back(*k / 4);
    const auto list = range.hinges.begin() + range.chunk_start.back();
    std::sort(list, range.hinges.end());
    range.hinges.erase(std::unique(list, range.hinges.end()), range.hinges.end());
    for (auto e = list; e < range.hinges.end(); ++e)
      for (const Index vertex : hinges_[*e].vertices) {
        const bool inside = vertex >= first && vertex < last;
        range.places.push_back(static_cast<std::uint8_t>(inside ? vertex - first : rows_per_block));
      }
    range.chunk_start.push_back(static_cast<Index>(range.hinges.size()));
  }
  for (const Index e : range.hinges) range.batches.push_back(e / n_lanes);
  sort_unique(range.batches);
}

void HingeSet::evaluate(const Team& team, const std::vector<Index>& batches, const Points& x,
                        const Points* v, bool with_gradient, HingeValues& values) const {
  const bool has_batches =
      values.batches == batches || static_cast<Index>(values.batches.size()) == n_batches();
  const bool same = (values.has_gradient || !with_gradient) && has_batches && keeps(x, values.x);
  if (same && !v) return;
  keep(x, values.x);
  values.batches = batches, values.has_gradient = with_gradient;
  const std::size_t n = static_cast<std::size_t>(n_batches()) * hinge::angle_stride;
  values.difference.resize(n), values.half_sine.resize(n), values.half_cosine.resize(n);
  if (v) values.rate.resize(n);
  if (with_gradient) values.gradient.resize(n * hinge::gradient_stride);
  const hinge::Output out{values.difference.data(), values.half_sine.data(),
                          values.half_cosine.data(), v ? values.rate.data() : nullptr,
                          with_gradient ? values.gradient.data() : nullptr};
  parallel_ranges(team, static_cast<Index>(batches.size()), hinge::batches_per_range,
                  [&](Index first, Index last) {
                    hinge::angles({vertices_.data(), rest_lanes_.data()}, batches.data() + first,
                                  last - first, x.data(), v ? v->data() : nullptr, out);
                  });
}

void HingeSet::gather(const Team& team, const HingeValues& values, const AlignedDoubles& moment,
                      const HingeRange& range, RowsOut force) const {
  const Index n_chunks = static_cast<Index>(range.chunk_start.size()) - 1;
  parallel_ranges(team, n_chunks, 1, [&](Index first_chunk, Index last_chunk) {
    double sums[4 * (rows_per_block + 1)];
    for (Index chunk = first_chunk; chunk < last_chunk; ++chunk) {
      const Index start = range.chunk_start[chunk];
      const hinge::HingeList list{range.hinges.data() + start,
                                  range.places.data() + 4 * static_cast<std::size_t>(start),
                                  range.chunk_start[chunk + 1] - start};
      hinge::add_moments(list, moment.data(), values.gradient.data(), rows_per_block + 1, sums);
      const Index first = range.begin + chunk * rows_per_block,
                  last = std::min(range.end, first + rows_per_block);
      for (Index row = first; row < last; ++row)
        for (int d = 0; d < 3; ++d) force(row, d) -= sums[4 * (row - first) + d];
    }
  });
}

Index HingeSet::count_degenerate(const HingeValues& values) const {
  Index count = 0;
  for (Index e = 0; e < n_hinges(); ++e) {
    const double* u = values.gradient.data() + hinge::gradient_stride * static_cast<std::size_t>(e);
    // The gradient at the first vertex is zero exactly if a triangle of the hinge has zero area.
    count += u[0] == 0.0 && u[1] == 0.0 && u[2] == 0.0;
  }
  return count;
}

std::vector<double> measure_angles(const std::vector<Hinge>& hinges, const Points& x) {
  const HingeSet set(static_cast<Index>(x.rows()), hinges, std::vector<double>(hinges.size(), 0.0));
  std::vector<Index> all(set.n_batches());
  std::iota(all.begin(), all.end(), 0);
  HingeValues values;
  set.evaluate(Team{}, all, x, nullptr, false, values);
  return {values.difference.begin(), values.difference.begin() + set.n_hinges()};
}

}  // namespace loomstone
