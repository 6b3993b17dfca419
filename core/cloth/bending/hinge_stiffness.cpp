#include "core/cloth/bending/hinge_stiffness.h"

#include <algorithm>
#include <cassert>

#include "core/base/sort_unique.h"
#include "core/cloth/bending/stiffness_kernels.h"

namespace loomstone {

namespace {
constexpr Index rows_per_chunk = 128;  // so few that the hinge data of a chunk fit into the cache
}

HingeStiffness::HingeStiffness(Index n_vertices, const HingeSet& hinges, HingePairs pairs)
    : pairs_(std::move(pairs)), n_vertices_(n_vertices) {
  place_.resize(4 * pairs_.hinge.size());
  for (Index e = 0; e < hinges.n_hinges(); ++e) {
    std::vector<Index> vertices;
    for (Index p = pairs_.start[e]; p < pairs_.start[e + 1]; ++p) {
      const auto& of_pair = hinges.hinges()[pairs_.hinge[p]].vertices;
      vertices.insert(vertices.end(), of_pair.begin(), of_pair.end());
    }
    sort_unique(vertices);
    assert(vertices.size() < 256 && "a hinge depends on at most six triangles of twelve vertices");
    for (Index p = pairs_.start[e]; p < pairs_.start[e + 1]; ++p)
      for (int j = 0; j < 4; ++j)
        place_[4 * static_cast<std::size_t>(p) + j] = static_cast<std::uint8_t>(
            std::lower_bound(vertices.begin(), vertices.end(),
                             hinges.hinges()[pairs_.hinge[p]].vertices[j]) -
            vertices.begin());
    stencil_.insert(stencil_.end(), vertices.begin(), vertices.end());
    stencil_start_.push_back(static_cast<Index>(stencil_.size()));
  }
}

std::vector<std::pair<Index, Index>> HingeStiffness::couplings(const HingeSet& hinges) const {
  std::vector<std::pair<Index, Index>> pairs;
  std::vector<Index> row;
  for (Index i = 0; i < n_vertices_; ++i) {
    row.clear();
    for (Index k = hinges.of_vertices().start[i]; k < hinges.of_vertices().start[i + 1]; ++k) {
      const Index e = hinges.of_vertices().items[k] / 4;
      row.insert(row.end(), stencil_.begin() + stencil_start_[e],
                 stencil_.begin() + stencil_start_[e + 1]);
    }
    sort_unique(row);
    for (const Index j : row)
      if (i < j) pairs.emplace_back(i, j);
  }
  return pairs;
}

void HingeStiffness::locate(const HingeSet& hinges, const BlockMatrix& matrix, Index begin,
                            Index end) {
  if (matrix.columns().data() == located_columns_ && matrix.n_blocks() == located_blocks_ &&
      begin == begin_ && end == end_)
    return;
  located_columns_ = matrix.columns().data(), located_blocks_ = matrix.n_blocks();
  begin_ = begin, end_ = end;
  const Incidence& incidence = hinges.of_vertices();
  row_blocks_.assign(1, 0);
  block_.clear(), chunk_.clear(), offset_.clear();
  chunk_start_.assign(1, 0);
  std::vector<Index> place(hinges.n_hinges());
  for (Index first = begin; first < end; first += rows_per_chunk) {
    const Index last = std::min(end, first + rows_per_chunk);
    const auto item = incidence.items.begin();
    for (auto k = item + incidence.start[first]; k < item + incidence.start[last]; ++k)
      chunk_.push_back(*k / 4);
    const auto list = chunk_.begin() + chunk_start_.back();
    std::sort(list, chunk_.end());
    chunk_.erase(std::unique(list, chunk_.end()), chunk_.end());
    Index size = 0;
    for (auto e = list; e < chunk_.end(); ++e) {
      place[*e] = size;
      size += stencil_start_[*e + 1] - stencil_start_[*e];
    }
    chunk_start_.push_back(static_cast<Index>(chunk_.size()));
    for (Index row = first; row < last; ++row) {
      for (Index k = incidence.start[row]; k < incidence.start[row + 1]; ++k) {
        const Index e = incidence.items[k] / 4;
        offset_.push_back(place[e]);
        for (Index s = stencil_start_[e]; s < stencil_start_[e + 1]; ++s)
          block_.push_back(matrix.find(row, stencil_[s]) - matrix.row_start()[row]);
      }
      row_blocks_.push_back(block_.size());
    }
  }
}

void HingeStiffness::add(const Team& team, const HingeProducts& products, Index begin, Index end,
                         BlockMatrix& matrix) {
  locate(products.hinges, matrix, begin, end);
  const Incidence& incidence = products.hinges.of_vertices();
  const stiffness::Tables tables{pairs_.start.data(), pairs_.hinge.data(),
                                 place_.data(),       stencil_start_.data(),
                                 products.q.data(),   products.values.gradient.data()};
  const Index n_chunks = static_cast<Index>(chunk_start_.size()) - 1;
  parallel_ranges(team, n_chunks, 1, [&](Index first_chunk, Index last_chunk) {
    AlignedDoubles moments, sums;
    for (Index chunk = first_chunk; chunk < last_chunk; ++chunk) {
      const Index* list = chunk_.data() + chunk_start_[chunk];
      const Index n_list = chunk_start_[chunk + 1] - chunk_start_[chunk];
      std::size_t size = 0;
      for (Index k = 0; k < n_list; ++k)
        size += stencil_start_[list[k] + 1] - stencil_start_[list[k]];
      if (moments.size() < 4 * size) moments.resize(4 * size);
      stiffness::moment_gradients(tables, list, n_list, moments.data());
      const Index first = begin + chunk * rows_per_chunk,
                  last = std::min(end, first + rows_per_chunk);
      for (Index row = first; row < last; ++row) {
        const Index item = incidence.start[row],
                    n_blocks = matrix.row_start()[row + 1] - matrix.row_start()[row];
        if (sums.size() < stiffness::row_scratch(n_blocks))
          sums.resize(stiffness::row_scratch(n_blocks));
        const stiffness::Row parts{
            incidence.items.data() + item, offset_.data() + (item - incidence.start[begin]),
            incidence.start[row + 1] - item, block_.data() + row_blocks_[row - begin], n_blocks};
        stiffness::add_row(tables, parts, moments.data(), products.scale, sums.data(),
                           matrix.block(matrix.row_start()[row]));
      }
    }
  });
}

}  // namespace loomstone
