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
  for (std::int64_t rank = 0; rank <= n_ranks; ++rank) {
    const Index first_block = static_cast<Index>(n_blocks * rank / n_ranks);
    starts_[rank] = std::min<Index>(n_rows, first_block * rows_per_block);
  }
  begin_ = starts_[communicator_->rank()], end_ = starts_[communicator_->rank() + 1];
}

int RowLayout::owner(Index row) const {
  return static_cast<int>(std::upper_bound(starts_.begin(), starts_.end(), row) - starts_.begin()) -
         1;
}

BinnedSum RowLayout::owned_sum(const std::vector<double>& block_sums) const {
  assert(static_cast<Index>(block_sums.size()) == blocks_of(n_rows()) &&
         "there must be one sum per block of all rows");
  BinnedSum sum;
  for (Index block = blocks_of(begin()); block < blocks_of(end()); ++block)
    sum.add(block_sums[block]);
  return sum;
}

double RowLayout::sum(const std::vector<double>& block_sums) const {
  BinnedSum sum = owned_sum(block_sums);
  communicator_->add(&sum, 1);
  return sum.value();
}

void HaloExchange::start_bytes(const Communicator& communicator, const Halo& halo, void* rows,
                               std::size_t row_bytes) {
  halo_ = &halo, rows_ = static_cast<std::byte*>(rows), row_bytes_ = row_bytes;
  std::size_t n_rows = 0;
  for (const Halo::Neighbour& neighbour : halo.neighbours)
    n_rows += neighbour.send.size() + neighbour.receive.size();
  buffer_.resize(n_rows * row_bytes);
  to_.clear(), from_.clear();
  std::byte* next = buffer_.data();
  const auto message = [&](int rank, std::size_t n) {
    const Communicator::Message made{rank, next, n * row_bytes};
    next += n * row_bytes;
    return made;
  };
  for (const Halo::Neighbour& neighbour : halo.neighbours) {
    to_.push_back(message(neighbour.rank, neighbour.send.size()));
    std::byte* slot = static_cast<std::byte*>(to_.back().data);
    for (const Index row : neighbour.send)
      slot = std::copy_n(rows_ + static_cast<std::size_t>(row) * row_bytes, row_bytes, slot);
    from_.push_back(message(neighbour.rank, neighbour.receive.size()));
  }
  communicator.start_exchange(to_, from_);
}

void HaloExchange::unpack() {
  for (std::size_t i = 0; i < from_.size(); ++i) {
    const std::byte* slot = static_cast<const std::byte*>(from_[i].data);
    for (const Index row : halo_->neighbours[i].receive) {
      std::copy_n(slot, row_bytes_, rows_ + static_cast<std::size_t>(row) * row_bytes_);
      slot += row_bytes_;
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
