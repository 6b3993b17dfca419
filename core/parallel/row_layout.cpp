// Row ranges of ranks, and the exchange of row values between ranks.
#include "core/parallel/row_layout.h"

#include <algorithm>
#include <cassert>

#include "core/parallel/team.h"

namespace loomstone {

namespace {

Index blocks_of(Index rows) { return (rows + rows_per_block - 1) / rows_per_block; }

}  // namespace

RowLayout::RowLayout(Index n_rows, std::shared_ptr<const Communicator> communicator)
    : communicator_(std::move(communicator)) {
  const std::int64_t n_blocks = blocks_of(n_rows), n_ranks = communicator_->size();
  starts_.resize(n_ranks + 1);
  sum_offsets_.resize(n_ranks + 1);
  for (std::int64_t rank = 0; rank <= n_ranks; ++rank) {
    const Index first_block = static_cast<Index>(n_blocks * rank / n_ranks);
    starts_[rank] = std::min<Index>(n_rows, first_block * rows_per_block);
    sum_offsets_[rank] = sizeof(double) * static_cast<std::size_t>(first_block);
  }
}

int RowLayout::owner(Index row) const {
  return static_cast<int>(std::upper_bound(starts_.begin(), starts_.end(), row) - starts_.begin()) -
         1;
}

double RowLayout::ordered_sum(std::vector<double>& block_sums) const {
  assert(static_cast<Index>(block_sums.size()) == blocks_of(n_rows()) &&
         "one sum a block of all rows");
  if (!single()) communicator_->gather_all(block_sums.data(), sum_offsets_);
  double total = 0.0;
  for (const double sum : block_sums) total += sum;
  return total;
}

void RowLayout::exchange_rows(const Halo& halo, void* rows, std::size_t row_bytes) const {
  if (single()) return;
  std::size_t n_rows = 0;
  for (const Halo::Neighbour& neighbour : halo.neighbours)
    n_rows += neighbour.send.size() + neighbour.receive.size();
  std::vector<std::byte> buffer(n_rows * row_bytes);
  std::vector<Communicator::Message> to, from;
  std::byte* next = buffer.data();
  const auto message = [&](int rank, std::size_t n) {
    const Communicator::Message made{rank, next, n * row_bytes};
    next += n * row_bytes;
    return made;
  };
  const auto row_at = [&](Index row) {
    return static_cast<std::byte*>(rows) + static_cast<std::size_t>(row) * row_bytes;
  };
  for (const Halo::Neighbour& neighbour : halo.neighbours) {
    to.push_back(message(neighbour.rank, neighbour.send.size()));
    std::byte* slot = static_cast<std::byte*>(to.back().data);
    for (const Index row : neighbour.send) slot = std::copy_n(row_at(row), row_bytes, slot);
    from.push_back(message(neighbour.rank, neighbour.receive.size()));
  }
  communicator_->exchange(to, from);
  for (std::size_t i = 0; i < halo.neighbours.size(); ++i) {
    const std::byte* slot = static_cast<const std::byte*>(from[i].data);
    for (const Index row : halo.neighbours[i].receive) {
      std::copy_n(slot, row_bytes, row_at(row));
      slot += row_bytes;
    }
  }
}

void RowLayout::gather(double* rows, Index stride) const {
  if (single()) return;
  std::vector<std::size_t> offsets;
  for (const Index start : starts_)
    offsets.push_back(sizeof(double) * static_cast<std::size_t>(start) * stride);
  communicator_->gather_all(rows, offsets);
}

}  // namespace loomstone
