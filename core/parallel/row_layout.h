// Assignment of rows to ranks. Every rank stores arrays of all rows in one fixed order, but
// computes only the contiguous range of rows that it owns. Rows of other ranks are refreshed by
// exchanging halos (few rows) or by gathering (all rows). Unlike in the common layout of owned rows
// followed by ghosts, row numbers are the same on all ranks. Collision handling needs every
// position on every rank, so full-length arrays are required anyway.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "core/base/types.h"
#include "core/parallel/communicator.h"

namespace loomstone {

// Rows to send to and to receive from each neighbouring rank, in ascending order.
struct Halo {
  struct Neighbour {
    int rank;
    std::vector<Index> send;     // rows this rank owns
    std::vector<Index> receive;  // rows the neighbour owns
  };
  std::vector<Neighbour> neighbours;
};

class RowLayout {
 public:
  // Splits `n_rows` rows into one contiguous range per rank. The ranges have nearly equal size and
  // start at multiples of rows_per_block.
  RowLayout(Index n_rows, std::shared_ptr<const Communicator> communicator);

  Index n_rows() const { return starts_.back(); }
  Index begin() const { return starts_[communicator_->rank()]; }
  Index end() const { return starts_[communicator_->rank() + 1]; }
  bool owns(Index row) const { return row >= begin() && row < end(); }
  int owner(Index row) const;
  const std::vector<Index>& starts() const { return starts_; }
  const Communicator& communicator() const { return *communicator_; }
  std::shared_ptr<const Communicator> shared_communicator() const { return communicator_; }
  bool single() const { return communicator_->size() == 1; }

  // Adds block sums over all ranks in block order, so that the result has the same bits on any
  // number of ranks. `block_sums` has one entry per block of all rows. On entry, the owned entries
  // are set. On return, all entries are set.
  double ordered_sum(std::vector<double>& block_sums) const;

  // Refreshes halo rows of a row-major array with `stride` numbers per row.
  void exchange(const Halo& halo, double* rows, Index stride) const {
    exchange_rows(halo, rows, stride * sizeof(double));
  }
  void exchange(const Halo& halo, float* rows, Index stride) const {
    exchange_rows(halo, rows, stride * sizeof(float));
  }

  // Refreshes all rows from their owners. Collective.
  void gather(double* rows, Index stride) const;

 private:
  void exchange_rows(const Halo& halo, void* rows, std::size_t row_bytes) const;

  std::vector<Index> starts_;
  std::vector<std::size_t> sum_offsets_;  // start of each rank's block sums [byte]
  std::shared_ptr<const Communicator> communicator_;
};

}  // namespace loomstone
