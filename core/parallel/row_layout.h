// Who owns which rows. Every rank holds arrays of all rows in one fixed order and computes only the
// contiguous range it owns; what others own is refreshed by exchanging halos (few rows) or
// gathering (all rows). This departs from "owned first, ghosts after": collision handling needs
// every position on every rank, so full-length arrays exist anyway, and row numbers mean the same
// everywhere.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "core/base/types.h"
#include "core/parallel/communicator.h"

namespace loomstone {

// Rows that go to and come from each neighbour, ascending.
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
  // Splits `n_rows` rows into contiguous ranges that start at multiples of rows_per_block, as even
  // as possible.
  RowLayout(Index n_rows, std::shared_ptr<const Communicator> communicator);

  Index n_rows() const { return starts_.back(); }
  Index begin() const { return starts_[communicator_->rank()]; }
  Index end() const { return starts_[communicator_->rank() + 1]; }
  bool owns(Index row) const { return row >= begin() && row < end(); }
  int owner(Index row) const;
  const std::vector<Index>& starts() const { return starts_; }
  const Communicator& communicator() const { return *communicator_; }
  bool single() const { return communicator_->size() == 1; }

  // Adds block sums (one double a block of the owned range) over all ranks in block order: same
  // bits on any rank count. `block_sums` has an entry for every block of all rows; the owned ones
  // are filled on entry, all on return.
  double ordered_sum(std::vector<double>& block_sums) const;

  // Refreshes rows of a row-major array with `stride` numbers a row.
  void exchange(const Halo& halo, double* rows, Index stride) const {
    exchange_rows(halo, rows, stride * sizeof(double));
  }
  void exchange(const Halo& halo, float* rows, Index stride) const {
    exchange_rows(halo, rows, stride * sizeof(float));
  }

  // Refreshes all rows.
  void gather(double* rows, Index stride) const;

 private:
  void exchange_rows(const Halo& halo, void* rows, std::size_t row_bytes) const;

  std::vector<Index> starts_;
  std::vector<std::size_t> sum_offsets_;  // of each rank's block sums [byte]
  std::shared_ptr<const Communicator> communicator_;
};

}  // namespace loomstone
