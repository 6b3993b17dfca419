// Ranges of rows, and the three ways their values travel between ranks.
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
  return static_cast<int>(std::upper_bound(starts_.begin(), starts_.end(), row) - starts_.begin()) - 1;
}

double RowLayout::ordered_sum(std::vector<double>& block_sums) const {
  assert(static_cast<Index>(block_sums.size()) == blocks_of(n_rows()) && "one sum a block of all rows");
  if (!single()) communicator_->gather_all(block_sums.data(), sum_offsets_);
  double total = 0.0;
  for (const double sum : block_sums) total += sum;
  return total;
}

void RowLayout::exchange(const Halo& halo, double* rows, Index stride) const {
  if (single()) return;
  std::size_t n_values = 0;
  for (const Halo::Neighbour& neighbour : halo.neighbours)
    n_values += static_cast<std::size_t>(stride) * (neighbour.send.size() + neighbour.receive.size());
  std::vector<double> buffer(n_values);
  std::vector<Communicator::Message> to, from;
  double* next = buffer.data();
  const auto message = [&](int rank, std::size_t n) {
    const Communicator::Message made{rank, next, n * stride * sizeof(double)};
    next += n * stride;
    return made;
  };
  const auto row_at = [&](Index row) { return rows + static_cast<std::size_t>(row) * stride; };
  for (const Halo::Neighbour& neighbour : halo.neighbours) {
    to.push_back(message(neighbour.rank, neighbour.send.size()));
    double* slot = static_cast<double*>(to.back().data);
    for (const Index row : neighbour.send) slot = std::copy_n(row_at(row), stride, slot);
    from.push_back(message(neighbour.rank, neighbour.receive.size()));
  }
  communicator_->exchange(to, from);
  for (std::size_t i = 0; i < halo.neighbours.size(); ++i) {
    const double* slot = static_cast<const double*>(from[i].data);
    for (const Index row : halo.neighbours[i].receive) {
      std::copy_n(slot, stride, row_at(row));
      slot += stride;
    }
  }
}

void RowLayout::gather(double* rows, Index stride) const {
  if (single()) return;
  std::vector<std::size_t> offsets;
  for (const Index start : starts_) offsets.push_back(sizeof(double) * static_cast<std::size_t>(start) * stride);
  communicator_->gather_all(rows, offsets);
}

}  // namespace loomstone
