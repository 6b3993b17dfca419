// A level of aggregation multigrid: its matrix with one row per node (coarse unknown), the vectors
// of a V-cycle, and the operations on them. The next level is the coarser one. A rank computes a
// range of the nodes of a level, which is the whole level if the level is replicated. Vectors have
// four numbers per node, of which the fourth is zero.
#pragma once

#include <utility>
#include <vector>

#include "core/base/bytes.h"
#include "core/linalg/coupling_matrix.h"
#include "core/parallel/binned_sum.h"
#include "core/parallel/row_layout.h"
#include "core/parallel/team.h"

namespace loomstone {

// Adds a 3x3 block to a sum of blocks.
inline void add_block(const double* block, double* sum) {
  for (int e = 0; e < 9; ++e) sum[e] += block[e];
}

struct MultigridLevel {
  // Nodes that this rank computes, and the nodes of the next level that consist of them.
  struct Range {
    Index begin = 0, end = 0;
    Index first_parent = 0, last_parent = 0;
  };

  BlockMatrix matrix;  // stores only the rows of `owned`
  Range owned;
  // (nodes of the next level + 1) First child on this level of each node of the next level. Empty
  // on the coarsest level, which has no slices either.
  std::vector<Index> child_start;
  std::vector<Index> target;        // (blocks) block of the next level to which each block is added
  SlicedEllpack slices;             // layout of the rows of `owned`
  CouplingMatrix<float> couplings;  // copy of `matrix` in this layout, for the kernels
  // (nodes x 12) Damped inverse diagonal blocks. Columns are padded to four numbers.
  std::vector<float> inverse;
  // ((nodes + n_spare) x 4) Vectors of the V-cycle. The n_spare rows after the nodes are zero.
  // Empty lanes of the slices refer to the first of these rows.
  std::vector<float> residual, solution, product;

  Index n_nodes() const { return matrix.n_rows(); }
  bool is_coarsest() const { return child_start.empty(); }

  // Groups the nodes [child_start[i], child_start[i + 1]) into node i of the next level. Returns
  // the pairs of different nodes of the next level that the stored rows couple. find_targets() must
  // follow.
  std::vector<std::pair<Index, Index>> group(std::vector<Index> child_start);
  void find_targets(const BlockMatrix& next);  // sets `target`
  // Sets `owned`, and allocates the arrays for the pattern of the matrix. n_spare must be at least
  // one.
  void allocate(Range range, Index n_spare = 1);

  // Sums the blocks of the matrix into blocks of the next level, in the rows of the owned parents.
  void sum_blocks(BlockMatrix& next) const;
  // Inverts the diagonal blocks of the owned nodes. In the matrix, zero blocks of nodes without a
  // free row are first replaced by the identity. Returns false if a block is not positive definite.
  bool invert_diagonal();
  void copy_couplings(const Team& team);

  // Operations of a V-cycle on the owned nodes, with the residual r. smooth() computes z = B r,
  // multiply() t = A z, and smooth_again() z += B (r - t). z is `solution`, t is `product`, and B
  // consists of the damped inverse diagonal blocks.
  void smooth(const Team& team, const float* r);
  void multiply(const Team& team);
  void smooth_again(const Team& team, const float* r);
  // Sets the residual `coarse` of each owned parent to the sum of r - t over its children.
  void restrict_residual(const Team& team, const float* r, float* coarse) const;
  // Adds the solution `coarse` of each owned parent to z at its children.
  void prolong(const Team& team, const float* coarse);
  // smooth_node() does smooth() for one node. add_to_node() adds `change` to `solution` at a node.
  void smooth_node(Index node, const float* r);
  void add_to_node(Index node, const float* change);
  // Returns the sum of z . (2 r - t) over the owned nodes, for z = B r and t = A z. This is r . C r
  // for the symmetric smoother C = 2 B - B A B, which consists of one sweep before and one after
  // the coarser levels.
  BinnedSum smoothed_product(const float* r) const;

  std::size_t bytes() const {
    return bytes_of(matrix, child_start, target, slices, couplings, inverse, residual, solution,
                    product);
  }

 private:
  std::vector<Index> parents() const;  // (nodes) parent of each node
};

}  // namespace loomstone
