#include "core/linalg/matrix_halo.h"

#include <algorithm>

#include "core/base/sort_unique.h"

namespace loomstone {

namespace {

// Collects the rows to be sent to and received from each rank. halo() sorts the rows and removes
// duplicates.
class HaloBuilder {
 public:
  HaloBuilder(const std::vector<Index>& starts, int rank)
      : starts_(starts),
        begin_(starts[rank]),
        end_(starts[rank + 1]),
        send_(starts.size() - 1),
        receive_(starts.size() - 1) {}

  // Records that the owned row `mine` is coupled to `other`.
  void couple(Index mine, Index other) {
    if (other >= begin_ && other < end_) return;
    const auto rank = std::upper_bound(starts_.begin(), starts_.end(), other) - starts_.begin() - 1;
    send_[rank].push_back(mine);
    receive_[rank].push_back(other);
  }

  void add(const Halo& halo) {
    for (const Halo::Neighbour& neighbour : halo.neighbours) {
      auto &send = send_[neighbour.rank], &receive = receive_[neighbour.rank];
      send.insert(send.end(), neighbour.send.begin(), neighbour.send.end());
      receive.insert(receive.end(), neighbour.receive.begin(), neighbour.receive.end());
    }
  }

  Halo halo() {
    Halo made;
    for (int rank = 0; rank < static_cast<int>(send_.size()); ++rank) {
      if (send_[rank].empty() && receive_[rank].empty()) continue;
      for (auto* rows : {&send_[rank], &receive_[rank]}) {
        sort_unique(*rows);
      }
      made.neighbours.push_back({rank, std::move(send_[rank]), std::move(receive_[rank])});
    }
    return made;
  }

 private:
  const std::vector<Index>& starts_;
  Index begin_, end_;
  std::vector<std::vector<Index>> send_, receive_;
};

}  // namespace

Halo matrix_halo(const BlockMatrix& matrix, const RowLayout& layout) {
  if (layout.single()) return {};
  return halo_of_ranges(matrix, layout.starts(), layout.communicator().rank());
}

Halo halo_of_ranges(const BlockMatrix& matrix, const std::vector<Index>& starts, int rank) {
  HaloBuilder builder(starts, rank);
  const Index end = std::min(starts[rank + 1], matrix.n_rows());
  for (Index row = starts[rank]; row < end; ++row)
    for (Index k = matrix.row_start()[row]; k < matrix.row_start()[row + 1]; ++k)
      builder.couple(row, matrix.columns()[k]);
  return builder.halo();
}

Halo with_term_rows(const Halo& halo, const ExtraTerms* terms, const RowLayout& layout) {
  if (layout.single()) return {};
  if (terms == nullptr || terms->empty()) return halo;
  HaloBuilder builder(layout.starts(), layout.communicator().rank());
  builder.add(halo);
  for (const ExtraTerm& term : *terms)
    for (int a = 0; a < term.n_entries; ++a) {
      if (!layout.owns(term.entries[a].row)) continue;
      for (int b = 0; b < term.n_entries; ++b)
        builder.couple(term.entries[a].row, term.entries[b].row);
    }
  return builder.halo();
}

}  // namespace loomstone
