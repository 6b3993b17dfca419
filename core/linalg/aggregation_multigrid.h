// Aggregation multigrid for the block matrix of a LinearSystem. A coarse unknown is a common
// translation: of an aggregate of rows on the first level, of a block of rows on the second, of
// four blocks on the third, and so on. The coarse correction is added to the correction by inverse
// diagonal blocks (additive, as in Bramble, Pasciak and Xu, Math. Comp. 55 (1990), with plain
// aggregation). The coarse levels form a V-cycle with one damped Jacobi sweep before and one after
// the coarser levels. The coarsest matrix is factorised. If the V-cycle is replaced by inverse
// diagonal blocks of the aggregates, steps of 4 ms take 1.03 times as long at 14,450 triangles and
// 1.15 times at 57,800. Except for the solve on the coarsest level, the V-cycle uses single
// precision, which suffices for a preconditioner.
//
// The first level is distributed unless it is the coarsest: every rank computes the aggregates of
// its own rows. From other ranks, it gets the residual of the aggregates to which its own are
// coupled (the halo). All other levels are replicated: the residual of the first of them is
// gathered, and all ranks do the same work. The residual r of the aggregates is updated in the
// steps of conjugate gradients, r -= alpha q, where q is the sum of A p over the rows of an
// aggregate. The halo of q can thus be exchanged while p . A p is summed over the ranks.
#pragma once

#include <vector>

#include <Eigen/Cholesky>

#include "core/base/bytes.h"
#include "core/linalg/aggregates.h"
#include "core/linalg/linear_solver.h"
#include "core/linalg/multigrid_level.h"
#include "core/linalg/pcg_kernels.h"

namespace loomstone {

// Sums of the residual r and of the product q = A p over the rows of each slot (see n_slots()),
// with four numbers per slot.
template <class Scalar>
struct SlotVectors {
  std::vector<Scalar> r, q;
};

class AggregationMultigrid {
 public:
  // Builds the levels for the pattern of `matrix`. Collective.
  void set_pattern(const BlockMatrix& matrix, const RowLayout& layout);
  // Computes the coarse matrices by summing the blocks of free cloth rows and columns, including
  // those of terms. Rebuilds the levels if terms couple aggregates that neither the matrix nor
  // earlier terms couple, or if too many couplings of earlier terms are unused. Inverts the
  // diagonal blocks and factorises the coarsest matrix; see usable(). `halo` contains the rows that
  // the matrix and the terms couple to owned rows. Collective.
  void prepare(const Team& team, const LinearSystem& system, const Halo& halo);

  // Returns false if the coarsest matrix or a diagonal block of any level is not positive definite.
  // In that case there is no correction.
  bool usable() const { return usable_; }

  // Number of slots. A slot is a place in SlotVectors to which rows are summed; SlicedEllpack uses
  // the word for something else. Each aggregate has one slot. Each block of rows has one additional
  // slot, for its rows that are summed in no aggregate (fixed rows, bodies) and for the empty lanes
  // of its slices.
  Index n_slots() const { return n_nodes_ + n_blocks_; }
  Index slot(Index row) const { return slot_[row]; }  // row: owned or in the halo
  Index unused_slot(Index block) const { return n_nodes_ + block; }

  // Sets the slots of one block in `sums` (slots x 4) to the sums of a vector v, stored by slices,
  // over the rows of each slot. The slices [first, last) form the block. Lane l of slice s has slot
  // slots[8 s + l].
  template <class Scalar>
  void sum_over_slots(Index first, Index last, const Index* slots, const Scalar* v,
                      std::vector<Scalar>& sums) const;
  template <class Scalar>
  SlotVectors<Scalar>& vectors();
  // Allocates the vectors in double precision.
  void widen();

  // Exchanges the halo of a vector (slots x 4). The exchange must be started and finished on all
  // ranks. Other operations of the communicator may be started in between. finish_exchange() must
  // follow Communicator::finish().
  template <class Scalar>
  void start_exchange(const RowLayout& layout, std::vector<Scalar>& v) {
    exchange_.start(layout.communicator(), halo_, v.data(), 4);
  }
  void finish_exchange() { exchange_.unpack(); }
  // Computes r -= alpha q for the owned aggregates and those of the halo.
  template <class Scalar>
  void take_step(Scalar alpha);

  // Computes the correction for the residual r. Returns the dot product of r and the correction.
  // With several levels, this product is computed as r . C r, with the symmetric smoother C of the
  // first level, plus the dot product of the residual and the solution on the second level. With
  // one level, it is the dot product of the residual and the solution on this level. Also replaces
  // `sum` by its total over all ranks. Collective.
  template <class Scalar>
  double solve(const Team& team, const RowLayout& layout, BinnedSum& sum);
  std::size_t bytes() const {
    return bytes_of(aggregates_, plain_, couplings_, place_, levels_, first_replicated_, target_,
                    slot_, gathered_, single_.r, single_.q, wide_.r, wide_.q);
  }
  // Returns the dot product of r and the correction over the owned aggregates.
  BinnedSum correction_product() const;
  // (slots x 4) Correction in the owned aggregates. The fourth column and the slots without an
  // aggregate are zero.
  const float* correction() const { return levels_[0].solution.data(); }

 private:
  using Couplings = std::vector<std::pair<Index, Index>>;
  struct TermNodes;

  static constexpr int n_sums = 2;  // number of sums that gather_residual() adds

  void lay_out(const RowLayout& layout);
  void lay_out_ranks(const RowLayout& layout);
  MultigridLevel::Range owned_nodes(const RowLayout& layout) const;
  void set_slots(const LinearSystem& system, const Halo& halo);
  void sum_rows(const Team& team, const LinearSystem& system);
  TermNodes nodes_of(const ExtraTerm& term, const RowLayout& layout) const;
  void couple_terms(const LinearSystem& system);
  Couplings couplings_of_terms(const LinearSystem& system) const;
  void add_terms(const LinearSystem& system);
  void gather_matrix(const RowLayout& layout);
  bool invert(const RowLayout& layout);
  void factorise();
  template <class Scalar>
  const float* first_residual();
  void gather_residual(const RowLayout& layout, BinnedSum* sums);
  void cycle(const Team& team, std::size_t level);

  Aggregates aggregates_;  // of all rows
  Index n_nodes_ = 0, n_blocks_ = 0;
  // Matrix of the aggregates, without blocks of terms. It stores only the rows of owned_.
  BlockMatrix plain_;
  // Pairs (first < second) of aggregates that the matrix does not couple, but that terms couple or
  // have coupled, in ascending order.
  Couplings couplings_;
  std::size_t n_owned_couplings_ = 0;  // number of couplings_ with an aggregate of this rank
  std::vector<Index> place_;           // (blocks of plain_) index of the block in levels_[0].matrix
  MultigridLevel::Range owned_;        // aggregates and blocks of rows of this rank
  Index first_block_ = 0;              // first block of rows of this rank
  std::vector<MultigridLevel> levels_;
  std::size_t replicated_ = 0;           // first level that all ranks compute
  std::vector<Index> first_replicated_;  // (ranks + 1) first node of each rank on level replicated_
  std::vector<Index> target_;  // (blocks of the matrix) block of plain_ that receives each block
  std::vector<Index> slot_;    // (rows) slot of each row
  Halo halo_;                  // halo of the first level
  struct Foreign {
    Index node, parent;
  };
  std::vector<Foreign> foreign_;  // aggregates of other ranks in the halo, with their parents
  HaloExchange exchange_;
  std::vector<std::byte> gathered_;       // message of gather_residual()
  std::vector<std::size_t> part_starts_;  // (ranks + 1) first byte of each rank in gathered_
  SlotVectors<float> single_;
  SlotVectors<double> wide_;  // allocated only if single precision does not suffice
  Eigen::LLT<Eigen::MatrixXd> coarsest_;
  bool usable_ = false;
};

}  // namespace loomstone
