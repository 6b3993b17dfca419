// Assignment of rows to ranks. There is one row per cloth vertex, followed by two rows per body
// (translation and rotation). Every rank stores vectors of all rows in one fixed order. It computes
// only the contiguous range of rows that it owns, and stores only the matrix rows of this range and
// the elements of one MeshPart (mesh_part.h). In asynchronous steps, every rank computes all rows.
// Rows of other ranks are refreshed by exchanging halos (few rows) or by gathering (all rows).
// Unlike in the common layout of owned rows followed by ghost rows, row numbers are the same on all
// ranks. Collision handling needs every position on every rank, so vectors must have full length
// anyway.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "core/base/types.h"
#include "core/parallel/communicator.h"

namespace loomstone {

// Rows to send to and to receive from each neighbouring rank. Each list of rows is in ascending
// order.
struct Halo {
  struct Neighbour {
    int rank;
    std::vector<Index> send;     // rows owned by this rank
    std::vector<Index> receive;  // rows owned by the neighbour
  };
  std::vector<Neighbour> neighbours;
};

class RowLayout {
 public:
  // Splits `n_rows` rows into one contiguous range per rank. The ranges have nearly equal size and
  // start at multiples of rows_per_block.
  RowLayout(Index n_rows, std::shared_ptr<const Communicator> communicator);

  Index n_rows() const { return starts_.back(); }
  Index begin() const { return begin_; }
  Index end() const { return end_; }
  bool owns(Index row) const { return row >= begin_ && row < end_; }
  int owner(Index row) const;
  const std::vector<Index>& starts() const { return starts_; }
  const Communicator& communicator() const { return *communicator_; }
  std::shared_ptr<const Communicator> shared_communicator() const { return communicator_; }
  bool single() const { return communicator_->size() == 1; }

  // Returns the total of the block sums of the rows that this rank owns. `block_sums` has one entry
  // per block of all rows.
  BinnedSum owned_sum(const std::vector<double>& block_sums) const;
  // Collective. Returns the sum of owned_sum() over all ranks. It has the same bits on any number
  // of ranks.
  double sum(const std::vector<double>& block_sums) const;

  // Refreshes halo rows from the ranks that own them. These ranks must call exchange() too. `rows`
  // is a row-major array with `stride` numbers per row.
  template <class Scalar>
  void exchange(const Halo& halo, Scalar* rows, Index stride) const;

  // Collective. Refreshes all rows from the ranks that own them.
  void gather(double* rows, Index stride) const;

 private:
  std::vector<Index> starts_;
  std::shared_ptr<const Communicator> communicator_;
  Index begin_, end_;  // rows of this rank
};

// An exchange of halo rows that can overlap with other work. The halo and the rows must stay in
// place until unpack() has returned. The object can be used again.
class HaloExchange {
 public:
  // Starts to send and receive rows of a row-major array with `stride` numbers per row.
  template <class Scalar>
  void start(const Communicator& communicator, const Halo& halo, Scalar* rows, Index stride) {
    start_bytes(communicator, halo, rows, stride * sizeof(Scalar));
  }
  // Writes the received rows to the array. Communicator::finish() must have been called.
  void unpack();

 private:
  void start_bytes(const Communicator& communicator, const Halo& halo, void* rows,
                   std::size_t row_bytes);

  const Halo* halo_ = nullptr;
  std::byte* rows_ = nullptr;
  std::size_t row_bytes_ = 0;
  std::vector<std::byte> buffer_;
  std::vector<Communicator::Message> to_, from_;
};

template <class Scalar>
void RowLayout::exchange(const Halo& halo, Scalar* rows, Index stride) const {
  if (single()) return;
  HaloExchange exchange;
  exchange.start(communicator(), halo, rows, stride);
  communicator().finish();
  exchange.unpack();
}

}  // namespace loomstone
