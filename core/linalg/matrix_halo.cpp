#include "core/linalg/matrix_halo.h"

#include <algorithm>

namespace loomstone {

namespace {

// Collects the rows to send to and to receive from each rank. halo() sorts the rows and removes
// duplicates.
class HaloBuilder {
 public:
  explicit HaloBuilder(const RowLayout& layout)
      : layout_(layout),
        send_(layout.communicator().size()),
        receive_(layout.communicator().size()) {}

  // Records that the owned row `mine` is coupled to `other`.
  void couple(Index mine, Index other) {
    if (layout_.owns(other)) return;
    const int rank = layout_.owner(other);
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
        std::sort(rows->begin(), rows->end());
        rows->erase(std::unique(rows->begin(), rows->end()), rows->end());
      }
      made.neighbours.push_back({rank, std::move(send_[rank]), std::move(receive_[rank])});
    }
    return made;
  }

 private:
  const RowLayout& layout_;
  std::vector<std::vector<Index>> send_, receive_;
};

}  // namespace

Halo matrix_halo(const BlockMatrix& matrix, const RowLayout& layout) {
  if (layout.single()) return {};
  HaloBuilder builder(layout);
  const Index end = std::min(layout.end(), matrix.n_rows());
  for (Index row = layout.begin(); row < end; ++row)
    for (Index k = matrix.row_start()[row]; k < matrix.row_start()[row + 1]; ++k)
      builder.couple(row, matrix.columns()[k]);
  return builder.halo();
}

Halo with_term_rows(const Halo& halo, const ExtraTerms& terms, const RowLayout& layout) {
  if (layout.single()) return {};
  HaloBuilder builder(layout);
  builder.add(halo);
  for (const ExtraTerm& term : terms)
    for (int a = 0; a < term.n_entries; ++a) {
      if (!layout.owns(term.entries[a].row)) continue;
      for (int b = 0; b < term.n_entries; ++b)
        builder.couple(term.entries[a].row, term.entries[b].row);
    }
  return builder.halo();
}

}  // namespace loomstone
