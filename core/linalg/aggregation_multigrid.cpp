#include "core/linalg/aggregation_multigrid.h"

#include <algorithm>
#include <array>
#include <iterator>

#include "core/linalg/quad.h"
#include "core/linalg/small.h"
#include "core/linalg/system.h"

namespace loomstone {

namespace {

constexpr Index largest_factor = 32;  // upper bound for the number of nodes on the coarsest level
constexpr Index parents_per_chunk = rows_per_block / 8;
constexpr Index chunks_a_task = 8;  // minimum work of a task: 1,024 nodes, about 5 us
constexpr Index chunks_of_product_a_task =
    2;  // minimum work of a product task: 256 nodes, about 5 us
// Damping of the Jacobi sweeps. The sweeps converge if each element or term couples at most four
// nodes, because the eigenvalues of D^-1 A are then below four. Elements that couple more nodes
// have not needed stronger damping. If a V-cycle is indefinite, its correction is dropped.
constexpr double damping = 0.5;

// Damped Jacobi sweep: z = B r with the blocks B, or z += B (r - t) if t is not null.
template <class>
LOOMSTONE_INLINE void smooth(Index first, Index last, const float* inverse, const float* r,
                             const float* t, float* z) {
  for (std::size_t i = first; i < static_cast<std::size_t>(last); ++i) {
    const float* b = inverse + 12 * i;
    FloatQuad v = quad_load(r + 4 * i), sum{};
    if (t) v -= quad_load(t + 4 * i), sum = quad_load(z + 4 * i);
    quad_store(z + 4 * i,
               ((sum + quad_load(b) * v[0]) + quad_load(b + 4) * v[1]) + quad_load(b + 8) * v[2]);
  }
}

// Calls body(first, last) on whole chunks of [0, n).
template <class Body>
void in_chunks(const Team& team, Index n, Index chunk, Body&& body,
               Index least_a_task = chunks_a_task) {
  const Index n_chunks = (n + chunk - 1) / chunk;
  parallel_ranges(team, n_chunks,
                  std::max(least_a_task, (n_chunks + team.threads - 1) / team.threads),
                  [&](Index first, Index last) { body(first * chunk, std::min(n, last * chunk)); });
}

void add_block(const double* block, double* sum) {
  for (int e = 0; e < 9; ++e) sum[e] += block[e];
}

}  // namespace

void AggregationMultigrid::set_pattern(const BlockMatrix& matrix) {
  aggregates_ = grow_aggregates(matrix);
  n_nodes_ = aggregates_.count();
  Couplings couplings;
  const auto of = [&](Index row) { return aggregates_.of_row[row]; };
  for (Index row = 0; row < matrix.n_rows(); ++row)
    for (Index k = matrix.row_start()[row]; k < matrix.row_start()[row + 1]; ++k)
      if (of(matrix.columns()[k]) > of(row))
        couplings.emplace_back(of(row), of(matrix.columns()[k]));
  plain_ = BlockMatrix(n_nodes_, couplings);
  target_.resize(matrix.n_blocks());
  for (Index row = 0; row < matrix.n_rows(); ++row)
    for (Index k = matrix.row_start()[row]; k < matrix.row_start()[row + 1]; ++k)
      target_[k] = plain_.find(of(row), of(matrix.columns()[k]));
  couplings_.clear();
  lay_out();
}

// Builds all levels for the couplings of the matrix plain_ and of the terms.
void AggregationMultigrid::lay_out() {
  const std::vector<Index>&start = plain_.row_start(), &columns = plain_.columns();
  Couplings couplings = couplings_;
  for (Index row = 0; row < n_nodes_; ++row)
    for (Index k = start[row]; k < start[row + 1]; ++k)
      if (columns[k] > row) couplings.emplace_back(row, columns[k]);
  levels_.clear();
  levels_.emplace_back();
  levels_[0].matrix = BlockMatrix(n_nodes_, couplings);
  place_.resize(plain_.n_blocks());
  for (Index row = 0; row < n_nodes_; ++row)
    for (Index k = start[row]; k < start[row + 1]; ++k)
      place_[k] = levels_[0].matrix.find(row, columns[k]);
  if (n_nodes_ > largest_factor) add_level(levels_[0], aggregates_.block_start);
  while (levels_.back().matrix.n_rows() > largest_factor) {
    const Index n = levels_.back().matrix.n_rows();
    std::vector<Index> first;
    for (Index node = 0; node < n; node += 4) first.push_back(node);
    first.push_back(n);
    add_level(levels_.back(), std::move(first));
  }
  for (Level& level : levels_) {
    const std::size_t n = level.matrix.n_rows();
    for (auto* v : {&level.residual, &level.solution, &level.product}) v->assign(4 * (n + 1), 0.0f);
    level.inverse.assign(12 * n, 0.0f);
    if (level.child_start.empty()) continue;
    level.slices.set_pattern(&level.matrix, level.matrix.n_rows());
    level.couplings.resize(level.slices);
  }
}

// Appends the next coarser level to levels_. `fine` must be the last level.
void AggregationMultigrid::add_level(Level& fine, std::vector<Index> child_start) {
  std::vector<Index> parent(fine.matrix.n_rows());
  for (std::size_t node = 0; node + 1 < child_start.size(); ++node)
    std::fill(parent.begin() + child_start[node], parent.begin() + child_start[node + 1],
              static_cast<Index>(node));
  std::vector<std::pair<Index, Index>> couplings;
  const std::vector<Index>&start = fine.matrix.row_start(), &columns = fine.matrix.columns();
  for (Index row = 0; row < fine.matrix.n_rows(); ++row)
    for (Index k = start[row]; k < start[row + 1]; ++k)
      if (parent[columns[k]] > parent[row]) couplings.emplace_back(parent[row], parent[columns[k]]);
  Level coarse;
  coarse.matrix = BlockMatrix(static_cast<Index>(child_start.size()) - 1, couplings);
  fine.target.resize(fine.matrix.n_blocks());
  for (Index row = 0; row < fine.matrix.n_rows(); ++row)
    for (Index k = start[row]; k < start[row + 1]; ++k)
      fine.target[k] = coarse.matrix.find(parent[row], parent[columns[k]]);
  fine.child_start = std::move(child_start);
  levels_.push_back(std::move(coarse));
}

void AggregationMultigrid::prepare(const Team& team, const LinearSystem& system) {
  const RowLayout& layout = *system.layout;
  n_blocks_ = (layout.n_rows() + rows_per_block - 1) / rows_per_block;
  slot_.resize(layout.n_rows());
  for (Index row = 0; row < layout.n_rows(); ++row)
    slot_[row] = row < n_cloth_rows(system) && !is_fixed(system, row)
                     ? aggregates_.of_row[row]
                     : n_nodes_ + row / rows_per_block;
  residual_.assign(4 * static_cast<std::size_t>(n_slots()), 0.0f);
  correction_ = residual_;
  sum_rows(team, system);
  gather_rows(layout);
  couple_terms(system);
  levels_[0].matrix.set_zero();
  for (Index k = 0; k < plain_.n_blocks(); ++k)
    add_block(plain_.block(k), levels_[0].matrix.block(place_[k]));
  add_terms(system);
  for (std::size_t l = 1; l < levels_.size(); ++l) sum_level(levels_[l - 1], levels_[l]);
  // The inversion comes last, so that the identity blocks it sets do not enter coarser levels.
  usable_ = std::all_of(levels_.begin(), levels_.end(),
                        [&](Level& level) { return invert_diagonal(level); });
  if (!usable_) return;
  for (Level& level : levels_)
    if (!level.child_start.empty())
      parallel_ranges(team, level.slices.n_slices(), 32, [&](Index first, Index last) {
        level.couplings.set_slices(&level.matrix, nullptr, level.slices, first, last);
      });
  const BlockMatrix& last = levels_.back().matrix;
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(3 * last.n_rows(), 3 * last.n_rows());
  for (Index row = 0; row < last.n_rows(); ++row)
    for (Index k = last.row_start()[row]; k < last.row_start()[row + 1]; ++k)
      dense.block<3, 3>(3 * row, 3 * last.columns()[k]) = last.block_map(k);
  coarsest_.compute(dense);
  usable_ = coarsest_.info() == Eigen::Success;
}

// Sums the blocks of this rank's free rows into plain_.
void AggregationMultigrid::sum_rows(const Team& team, const LinearSystem& system) {
  const BlockMatrix& matrix = *system.matrix;
  const OwnedBlocks owned = owned_blocks(*system.layout);
  const Index last_block =
      std::min<Index>(owned.last, static_cast<Index>(aggregates_.block_start.size()) - 1);
  parallel_for(
      team, std::max<Index>(0, last_block - owned.first),
      [&](Index i) {
        const Index block = owned.first + i,
                    end = std::min(matrix.n_rows(), (block + 1) * rows_per_block);
        const Index from = plain_.row_start()[aggregates_.block_start[block]];
        const Index to = plain_.row_start()[aggregates_.block_start[block + 1]];
        std::fill(plain_.block(from), plain_.block(to), 0.0);
        for (Index row = block * rows_per_block; row < end; ++row) {
          if (slot_[row] >= n_nodes_) continue;
          for (Index k = matrix.row_start()[row]; k < matrix.row_start()[row + 1]; ++k)
            if (slot_[matrix.columns()[k]] < n_nodes_)
              add_block(matrix.block(k), plain_.block(target_[k]));
        }
      },
      4);
}

// Returns the first aggregate of the first block that begins at or after this row.
Index AggregationMultigrid::first_node(Index row) const {
  const std::size_t block = static_cast<std::size_t>((row + rows_per_block - 1) / rows_per_block);
  return aggregates_.block_start[std::min(block, aggregates_.block_start.size() - 1)];
}

void AggregationMultigrid::gather_rows(const RowLayout& layout) {
  if (layout.single()) return;
  std::vector<std::size_t> offsets;
  for (const Index start : layout.starts())
    offsets.push_back(9 * sizeof(double) *
                      static_cast<std::size_t>(plain_.row_start()[first_node(start)]));
  layout.communicator().gather_all(plain_.block(0), offsets);
}

// Aggregates on which a term acts, each with the sum of the term's weights in it.
struct AggregationMultigrid::TermNodes {
  std::array<Index, 8> node;
  std::array<double, 8> weight;
  int n = 0;
};

AggregationMultigrid::TermNodes AggregationMultigrid::nodes_of(const ExtraTerm& term) const {
  TermNodes nodes;
  for (int e = 0; e < term.n_entries; ++e) {
    const Index at = slot_[term.entries[e].row];
    if (at >= n_nodes_) continue;
    int i = 0;
    while (i < nodes.n && nodes.node[i] != at) ++i;
    if (i == nodes.n) nodes.node[i] = at, nodes.weight[nodes.n++] = 0.0;
    nodes.weight[i] += term.entries[e].weight;
  }
  return nodes;
}

// Adds the couplings between aggregates that only terms couple, for example where layers touch.
// Couplings whose terms have vanished are kept until they are the majority, because separated
// layers often touch again. Their blocks are zero. Every rank knows all terms.
void AggregationMultigrid::couple_terms(const LinearSystem& system) {
  if (!system.terms) return;
  Couplings wanted;
  for (const ExtraTerm& term : *system.terms) {
    const TermNodes nodes = nodes_of(term);
    for (int i = 0; i < nodes.n; ++i)
      for (int j = 0; j < nodes.n; ++j)
        if (nodes.node[i] < nodes.node[j] && plain_.find(nodes.node[i], nodes.node[j]) < 0)
          wanted.emplace_back(nodes.node[i], nodes.node[j]);
  }
  std::sort(wanted.begin(), wanted.end());
  wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
  const std::size_t most = 2 * wanted.size() + 64;
  const bool there =
      std::includes(couplings_.begin(), couplings_.end(), wanted.begin(), wanted.end());
  if (there && couplings_.size() <= most) return;
  Couplings all;
  std::set_union(couplings_.begin(), couplings_.end(), wanted.begin(), wanted.end(),
                 std::back_inserter(all));
  couplings_ = all.size() <= most ? std::move(all) : std::move(wanted);
  lay_out();
}

// For each term, adds term_scale W_I W_J H to block (I, J) of the first level. H is the Hessian of
// the term, and W_I is the sum of its weights in aggregate I. Every rank knows all terms.
void AggregationMultigrid::add_terms(const LinearSystem& system) {
  if (!system.terms) return;
  BlockMatrix& first = levels_[0].matrix;
  for (const ExtraTerm& term : *system.terms) {
    const TermNodes nodes = nodes_of(term);
    for (int i = 0; i < nodes.n; ++i)
      for (int j = 0; j < nodes.n; ++j)
        first.block_map(first.find(nodes.node[i], nodes.node[j])) +=
            system.term_scale * nodes.weight[i] * nodes.weight[j] * term.hessian;
  }
}

void AggregationMultigrid::sum_level(const Level& fine, Level& coarse) const {
  coarse.matrix.set_zero();
  for (Index k = 0; k < fine.matrix.n_blocks(); ++k)
    add_block(fine.matrix.block(k), coarse.matrix.block(fine.target[k]));
}

// Inverts the diagonal blocks. Nodes without a free row get the identity. Returns false if a block
// is not positive definite.
bool AggregationMultigrid::invert_diagonal(Level& level) const {
  for (Index node = 0; node < level.matrix.n_rows(); ++node) {
    auto block = level.matrix.block_map(level.matrix.diagonal()[node]);
    if (block.isZero(0.0)) block.setIdentity();
    Mat3 inverse;
    if (!invert_positive_definite(block, inverse)) return false;
    float* out = level.inverse.data() + 12 * static_cast<std::size_t>(node);
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) out[4 * c + r] = static_cast<float>(damping * inverse(r, c));
  }
  return true;
}

void AggregationMultigrid::clear_residual(Index block) {
  const auto clear = [&](Index first, Index last) {
    std::fill_n(residual_.begin() + 4 * static_cast<std::size_t>(first),
                4 * static_cast<std::size_t>(last - first), 0.0f);
  };
  if (block + 1 < static_cast<Index>(aggregates_.block_start.size()))
    clear(aggregates_.block_start[block], aggregates_.block_start[block + 1]);
  clear(n_nodes_ + block, n_nodes_ + block + 1);
}

double AggregationMultigrid::solve(const Team& team, const RowLayout& layout) {
  if (!layout.single()) {
    std::vector<std::size_t> offsets;
    for (const Index start : layout.starts())
      offsets.push_back(4 * sizeof(float) * static_cast<std::size_t>(first_node(start)));
    layout.communicator().gather_all(residual_.data(), offsets);
  }
  const std::size_t size = 4 * static_cast<std::size_t>(n_nodes_);
  std::copy_n(residual_.begin(), size, levels_[0].residual.begin());
  cycle(team, 0);
  std::copy_n(levels_[0].solution.begin(), size, correction_.begin());
  double product = 0.0;
  for (std::size_t i = 0; i < size; ++i)
    product += static_cast<double>(residual_[i]) * static_cast<double>(correction_[i]);
  return product;
}

void AggregationMultigrid::cycle(const Team& team, std::size_t l) {
  Level& level = levels_[l];
  const Index n = level.matrix.n_rows();
  float *r = level.residual.data(), *z = level.solution.data(), *t = level.product.data();
  if (level.child_start.empty()) {
    Vector values(3 * n);
    for (Index i = 0; i < n; ++i)
      values.segment<3>(3 * i) = Eigen::Map<const Eigen::Vector3f>(r + 4 * i).cast<double>();
    coarsest_.solveInPlace(values);
    for (Index i = 0; i < n; ++i)
      Eigen::Map<Eigen::Vector3f>(z + 4 * i) = values.segment<3>(3 * i).cast<float>();
    return;
  }
  const float* inverse = level.inverse.data();
  const auto multiply = [&](Index first, Index last) {
    level.couplings.multiply_to_rows(level.slices, SlicedEllpack::first_slice(first),
                                     SlicedEllpack::last_slice(last), z, t);
  };
  in_chunks(team, n, rows_per_block, [&](Index first, Index last) {
    LOOMSTONE_WIDEST(smooth)(first, last, inverse, r, nullptr, z);
  });
  in_chunks(team, n, rows_per_block, multiply, chunks_of_product_a_task);
  Level& next = levels_[l + 1];
  const Index n_next = next.matrix.n_rows();
  in_chunks(team, n_next, parents_per_chunk, [&](Index first, Index last) {
    for (Index parent = first; parent < last; ++parent) {
      FloatQuad sum{};
      for (std::size_t i = level.child_start[parent];
           i < static_cast<std::size_t>(level.child_start[parent + 1]); ++i)
        sum += quad_load(r + 4 * i) - quad_load(t + 4 * i);
      quad_store(next.residual.data() + 4 * static_cast<std::size_t>(parent), sum);
    }
  });
  cycle(team, l + 1);
  in_chunks(team, n_next, parents_per_chunk, [&](Index first, Index last) {
    for (Index parent = first; parent < last; ++parent) {
      const FloatQuad change =
          quad_load(next.solution.data() + 4 * static_cast<std::size_t>(parent));
      for (std::size_t i = level.child_start[parent];
           i < static_cast<std::size_t>(level.child_start[parent + 1]); ++i)
        quad_store(z + 4 * i, quad_load(z + 4 * i) + change);
    }
  });
  in_chunks(team, n, rows_per_block, multiply, chunks_of_product_a_task);
  in_chunks(team, n, rows_per_block, [&](Index first, Index last) {
    LOOMSTONE_WIDEST(smooth)(first, last, inverse, r, t, z);
  });
}

}  // namespace loomstone
