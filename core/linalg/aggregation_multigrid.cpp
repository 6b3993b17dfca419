#include "core/linalg/aggregation_multigrid.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <iterator>

#include "core/base/sort_unique.h"
#include "core/linalg/flush_to_zero.h"
#include "core/linalg/matrix_halo.h"
#include "core/linalg/quad.h"
#include "core/linalg/system.h"

namespace loomstone {

namespace {

constexpr Index largest_factor = 32;  // upper bound for the number of nodes on the coarsest level

// Returns the sum of a . b over the nodes [first, last).
template <class>
LOOMSTONE_INLINE double dots(Index first, Index last, const float* a, const float* b) {
  Quad sum{};
  for (std::size_t i = first; i < static_cast<std::size_t>(last); ++i)
    sum += __builtin_convertvector(quad_load(a + 4 * i), Quad) *
           __builtin_convertvector(quad_load(b + 4 * i), Quad);
  return quad_sum(sum);
}

// Returns the union of the pairs `mine` of all ranks, sorted and without duplicates. Collective.
std::vector<std::pair<Index, Index>> pairs_of_all(
    const Communicator& ranks, const std::vector<std::pair<Index, Index>>& mine) {
  std::vector<std::size_t> starts(ranks.size() + 1, 0), by_rank(ranks.size() + 1);
  for (int rank = 0; rank <= ranks.size(); ++rank) by_rank[rank] = rank * sizeof(std::size_t);
  starts[ranks.rank()] = 2 * mine.size();
  ranks.gather_all(starts.data(), by_rank);
  std::size_t total = 0;
  for (std::size_t& start : starts) start = std::exchange(total, total + start);
  std::vector<Index> flat(total);
  std::size_t next = starts[ranks.rank()];
  for (const auto& [first, second] : mine) flat[next++] = first, flat[next++] = second;
  for (std::size_t& start : starts) start *= sizeof(Index);
  ranks.gather_all(flat.data(), starts);
  std::vector<std::pair<Index, Index>> all;
  for (std::size_t i = 0; i < total; i += 2) all.emplace_back(flat[i], flat[i + 1]);
  sort_unique(all);
  return all;
}

}  // namespace

void AggregationMultigrid::set_pattern(const BlockMatrix& matrix, const RowLayout& layout) {
  aggregates_ = grow_aggregates(matrix, layout);
  n_nodes_ = aggregates_.count();
  n_blocks_ = (layout.n_rows() + rows_per_block - 1) / rows_per_block;
  owned_ = owned_nodes(layout);
  first_block_ = (layout.begin() + rows_per_block - 1) / rows_per_block;
  const Index begin = std::min(layout.begin(), matrix.n_rows()),
              end = std::min(layout.end(), matrix.n_rows());
  Couplings couplings;
  const auto of = [&](Index row) { return aggregates_.of_row[row]; };
  for (Index row = begin; row < end; ++row)
    for (Index k = matrix.row_start()[row]; k < matrix.row_start()[row + 1]; ++k)
      if (of(matrix.columns()[k]) != of(row))
        couplings.emplace_back(of(row), of(matrix.columns()[k]));
  plain_ = BlockMatrix(n_nodes_, couplings, owned_.begin, owned_.end);
  target_.resize(matrix.n_blocks());
  for (Index row = begin; row < end; ++row)
    for (Index k = matrix.row_start()[row]; k < matrix.row_start()[row + 1]; ++k)
      target_[k] = plain_.find(of(row), of(matrix.columns()[k]));
  couplings_.clear();
  n_owned_couplings_ = 0;
  lay_out(layout);
}

// Returns the aggregates and the blocks of rows that this rank owns.
MultigridLevel::Range AggregationMultigrid::owned_nodes(const RowLayout& layout) const {
  const auto block_of = [&](Index row) {
    return std::min<Index>((row + rows_per_block - 1) / rows_per_block,
                           static_cast<Index>(aggregates_.block_start.size()) - 1);
  };
  const Index first = block_of(layout.begin()), last = block_of(layout.end());
  return {aggregates_.block_start[first], aggregates_.block_start[last], first, last};
}

// Builds all levels for the couplings of the matrix plain_ and of the terms.
void AggregationMultigrid::lay_out(const RowLayout& layout) {
  const std::vector<Index>&start = plain_.row_start(), &columns = plain_.columns();
  Couplings couplings = couplings_;
  for (Index row = 0; row < n_nodes_; ++row)
    for (Index k = start[row]; k < start[row + 1]; ++k)
      if (columns[k] != row) couplings.emplace_back(row, columns[k]);
  const bool distributed = n_nodes_ > largest_factor;
  if (!distributed) couplings = pairs_of_all(layout.communicator(), couplings);
  levels_.clear();
  levels_.emplace_back();
  levels_[0].matrix = BlockMatrix(n_nodes_, couplings, distributed ? owned_.begin : 0,
                                  distributed ? owned_.end : n_nodes_);
  place_.resize(plain_.n_blocks());
  for (Index row = 0; row < n_nodes_; ++row)
    for (Index k = start[row]; k < start[row + 1]; ++k)
      place_[k] = levels_[0].matrix.find(row, columns[k]);
  while (levels_.back().n_nodes() > largest_factor) {
    std::vector<Index> first_children = aggregates_.block_start;
    if (levels_.size() > 1) {
      const Index n = levels_.back().n_nodes();
      first_children.clear();
      for (Index node = 0; node < n; node += 4) first_children.push_back(node);
      first_children.push_back(n);
    }
    const Index n_parents = static_cast<Index>(first_children.size()) - 1;
    couplings = levels_.back().group(std::move(first_children));
    // In the distributed first level, each rank has found only the couplings due to its own rows.
    // The second level is the same on all ranks, and needs all couplings.
    if (levels_.size() == 1) couplings = pairs_of_all(layout.communicator(), couplings);
    MultigridLevel next;
    next.matrix = BlockMatrix(n_parents, couplings);
    levels_.back().find_targets(next.matrix);
    levels_.push_back(std::move(next));
  }
  replicated_ = levels_.size() > 1 ? 1 : 0;
  for (std::size_t l = 0; l < levels_.size(); ++l) {
    const Index n = levels_[l].n_nodes();
    const Index n_parents = l + 1 < levels_.size() ? levels_[l + 1].n_nodes() : 0;
    levels_[l].allocate(l < replicated_ ? owned_ : MultigridLevel::Range{0, n, 0, n_parents},
                        l == 0 ? n_blocks_ + 1 : 1);
  }
  lay_out_ranks(layout);
}

// Sets first_replicated_, the halo of the first level, foreign_, and the layout of the message of
// gather_residual().
void AggregationMultigrid::lay_out_ranks(const RowLayout& layout) {
  const int n_ranks = layout.communicator().size();
  std::vector<Index> first_nodes;
  first_replicated_.clear(), part_starts_.assign(1, 0), foreign_.clear();
  halo_ = {};
  for (const Index row : layout.starts()) {
    const std::size_t block = std::min<std::size_t>((row + rows_per_block - 1) / rows_per_block,
                                                    aggregates_.block_start.size() - 1);
    first_nodes.push_back(aggregates_.block_start[block]);
    first_replicated_.push_back(replicated_ == 0 ? first_nodes.back() : static_cast<Index>(block));
  }
  for (int rank = 0; rank < n_ranks; ++rank)
    part_starts_.push_back(
        part_starts_.back() + n_sums * sizeof(BinnedSum) +
        4 * sizeof(float) *
            static_cast<std::size_t>(first_replicated_[rank + 1] - first_replicated_[rank]));
  gathered_.resize(part_starts_.back());
  if (layout.single() || replicated_ == 0) return;
  halo_ = halo_of_ranges(levels_[0].matrix, first_nodes, layout.communicator().rank());
  const std::vector<Index>& starts = aggregates_.block_start;
  for (const Halo::Neighbour& neighbour : halo_.neighbours)
    for (const Index node : neighbour.receive)
      foreign_.push_back(
          {node, static_cast<Index>(std::upper_bound(starts.begin(), starts.end(), node) -
                                    starts.begin() - 1)});
}

void AggregationMultigrid::prepare(const Team& team, const LinearSystem& system, const Halo& halo) {
  const RowLayout& layout = *system.layout;
  set_slots(system, halo);
  single_.r.assign(4 * static_cast<std::size_t>(n_slots()), 0.0f);
  single_.q = single_.r;
  sum_rows(team, system);
  couple_terms(system);
  BlockMatrix& first = levels_[0].matrix;
  std::fill(first.block(first.row_start()[owned_.begin]),
            first.block(first.row_start()[owned_.end]), 0.0);
  for (Index k = plain_.row_start()[owned_.begin]; k < plain_.row_start()[owned_.end]; ++k)
    add_block(plain_.block(k), first.block(place_[k]));
  add_terms(system);
  if (replicated_ > 0) levels_[0].sum_blocks(levels_[1].matrix);
  gather_matrix(layout);
  for (std::size_t l = replicated_; l + 1 < levels_.size(); ++l)
    levels_[l].sum_blocks(levels_[l + 1].matrix);
  usable_ = invert(layout);
  if (!usable_) return;
  for (MultigridLevel& level : levels_)
    if (!level.is_coarsest()) level.copy_couplings(team);
  factorise();
}

// Inverts the diagonal blocks of all levels. The matrices of all levels must already have been
// summed, because this function replaces some blocks by the identity, which must not enter coarser
// levels. Returns false on all ranks if a block of any rank is not positive definite. Collective.
bool AggregationMultigrid::invert(const RowLayout& layout) {
  const bool mine = std::all_of(levels_.begin(), levels_.end(),
                                [](MultigridLevel& level) { return level.invert_diagonal(); });
  if (layout.communicator().maximum(mine ? 0 : 1) > 0) return false;
  layout.exchange(halo_, levels_[0].inverse.data(), 12);
  return true;
}

void AggregationMultigrid::factorise() {
  const BlockMatrix& last = levels_.back().matrix;
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(3 * last.n_rows(), 3 * last.n_rows());
  for (Index row = 0; row < last.n_rows(); ++row)
    for (Index k = last.row_start()[row]; k < last.row_start()[row + 1]; ++k)
      dense.block<3, 3>(3 * row, 3 * last.columns()[k]) = last.block_map(k);
  coarsest_.compute(dense);
  usable_ = coarsest_.info() == Eigen::Success;
}

// Sets the slots (see n_slots()) of the owned rows and of the rows of `halo`.
void AggregationMultigrid::set_slots(const LinearSystem& system, const Halo& halo) {
  const RowLayout& layout = *system.layout;
  slot_.resize(layout.n_rows());
  const auto set = [&](Index row) {
    slot_[row] = row < n_cloth_rows(system) && !is_fixed(system, row)
                     ? aggregates_.of_row[row]
                     : n_nodes_ + row / rows_per_block;
  };
  for (Index row = layout.begin(); row < layout.end(); ++row) set(row);
  for (const Halo::Neighbour& neighbour : halo.neighbours)
    for (const Index row : neighbour.receive) set(row);
}

// Sums the blocks of this rank's rows into plain_, if their row and column are free.
void AggregationMultigrid::sum_rows(const Team& team, const LinearSystem& system) {
  const BlockMatrix& matrix = *system.matrix;
  parallel_for(
      team, owned_.last_parent - owned_.first_parent,
      [&](Index i) {
        const FlushToZero flush;
        const Index block = owned_.first_parent + i,
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

// Gathers the rows of the matrix of the first replicated level.
void AggregationMultigrid::gather_matrix(const RowLayout& layout) {
  if (layout.single()) return;
  BlockMatrix& matrix = levels_[replicated_].matrix;
  std::vector<std::size_t> offsets;
  for (const Index node : first_replicated_)
    offsets.push_back(9 * sizeof(double) * static_cast<std::size_t>(matrix.row_start()[node]));
  layout.communicator().gather_all(matrix.block(0), offsets);
}

// Aggregates on which a term acts, each with the sum of the term's weights in it.
struct AggregationMultigrid::TermNodes {
  std::array<Index, 8> node;
  std::array<double, 8> weight;
  int n = 0;
};

// Returns the aggregates on which a term acts, or none if the term does not act on an owned row.
AggregationMultigrid::TermNodes AggregationMultigrid::nodes_of(const ExtraTerm& term,
                                                               const RowLayout& layout) const {
  TermNodes nodes;
  const auto end = term.entries.begin() + term.n_entries;
  if (std::none_of(term.entries.begin(), end,
                   [&](const TermEntry& entry) { return layout.owns(entry.row); }))
    return nodes;
  for (auto entry = term.entries.begin(); entry != end; ++entry) {
    const Index at = slot_[entry->row];
    if (at >= n_nodes_) continue;
    int i = 0;
    while (i < nodes.n && nodes.node[i] != at) ++i;
    if (i == nodes.n) nodes.node[i] = at, nodes.weight[nodes.n++] = 0.0;
    nodes.weight[i] += entry->weight;
  }
  return nodes;
}

// Returns the pairs of aggregates that terms couple but the matrix does not, for example where
// layers of cloth touch. At least one aggregate of each pair is owned.
AggregationMultigrid::Couplings AggregationMultigrid::couplings_of_terms(
    const LinearSystem& system) const {
  Couplings wanted;
  const auto owns = [&](Index node) { return node >= owned_.begin && node < owned_.end; };
  // A pair without an owned aggregate counts as coupled, because other ranks handle it.
  const auto coupled = [&](Index a, Index b) {
    return owns(a) ? plain_.find(a, b) >= 0 : !owns(b) || plain_.find(b, a) >= 0;
  };
  for (const ExtraTerm& term : *system.terms) {
    const TermNodes nodes = nodes_of(term, *system.layout);
    for (int i = 0; i < nodes.n; ++i)
      for (int j = 0; j < nodes.n; ++j)
        if (nodes.node[i] < nodes.node[j] && !coupled(nodes.node[i], nodes.node[j]))
          wanted.emplace_back(nodes.node[i], nodes.node[j]);
  }
  sort_unique(wanted);
  return wanted;
}

// Adds the couplings of terms to couplings_. Couplings whose terms have vanished are kept until
// they outnumber those that have terms by more than 64, because separated layers often touch again.
// The blocks of couplings without terms are zero and do not change results. The ranks exchange
// couplings and rebuild the levels only if a rank lacks a coupling or has too many couplings
// without terms.
void AggregationMultigrid::couple_terms(const LinearSystem& system) {
  if (!system.terms) return;
  const Communicator& ranks = system.layout->communicator();
  Couplings wanted = couplings_of_terms(system);
  const auto most = [&] { return 2 * wanted.size() + 64; };
  const bool there =
      std::includes(couplings_.begin(), couplings_.end(), wanted.begin(), wanted.end());
  const bool missing = !there || n_owned_couplings_ > most();
  if (ranks.maximum(missing ? 1 : 0) == 0) return;
  wanted = pairs_of_all(ranks, wanted);
  Couplings all;
  std::set_union(couplings_.begin(), couplings_.end(), wanted.begin(), wanted.end(),
                 std::back_inserter(all));
  couplings_ = all.size() <= most() ? std::move(all) : std::move(wanted);
  const auto owns = [&](Index node) { return node >= owned_.begin && node < owned_.end; };
  n_owned_couplings_ = std::count_if(
      couplings_.begin(), couplings_.end(),
      [&](const std::pair<Index, Index>& pair) { return owns(pair.first) || owns(pair.second); });
  lay_out(*system.layout);
}

// For each term, adds term_scale W_I W_J H to block (I, J) of the first level, in owned rows. H is
// the Hessian of the term, and W_I is the sum of its weights in aggregate I.
void AggregationMultigrid::add_terms(const LinearSystem& system) {
  if (!system.terms) return;
  BlockMatrix& first = levels_[0].matrix;
  for (const ExtraTerm& term : *system.terms) {
    const TermNodes nodes = nodes_of(term, *system.layout);
    for (int i = 0; i < nodes.n; ++i) {
      if (nodes.node[i] < owned_.begin || nodes.node[i] >= owned_.end) continue;
      for (int j = 0; j < nodes.n; ++j)
        first.block_map(first.find(nodes.node[i], nodes.node[j])) +=
            system.term_scale * nodes.weight[i] * nodes.weight[j] * term.hessian;
    }
  }
}

template <>
SlotVectors<float>& AggregationMultigrid::vectors() {
  return single_;
}
template <>
SlotVectors<double>& AggregationMultigrid::vectors() {
  return wide_;
}

void AggregationMultigrid::widen() {
  wide_.r.assign(single_.r.size(), 0.0);
  wide_.q = wide_.r;
}

template <class Scalar>
void AggregationMultigrid::sum_over_slots(Index first, Index last, const Index* slots,
                                          const Scalar* v, std::vector<Scalar>& sums) const {
  const Index block = first_block_ + 8 * first / rows_per_block;
  const auto clear = [&](Index begin, Index end) {
    std::fill(sums.begin() + 4 * static_cast<std::size_t>(begin),
              sums.begin() + 4 * static_cast<std::size_t>(end), Scalar{0});
  };
  if (block + 1 < static_cast<Index>(aggregates_.block_start.size()))
    clear(aggregates_.block_start[block], aggregates_.block_start[block + 1]);
  clear(unused_slot(block), unused_slot(block) + 1);
  pcg::add_up(first, last, slots, v, sums.data());
}

template <class Scalar>
void AggregationMultigrid::take_step(Scalar alpha) {
  SlotVectors<Scalar>& v = vectors<Scalar>();
  const auto step = [&](Index begin, Index end) {
    for (std::size_t i = 4 * static_cast<std::size_t>(begin); i < 4 * static_cast<std::size_t>(end);
         ++i)
      v.r[i] -= alpha * v.q[i];
  };
  step(owned_.begin, owned_.end);
  for (const Foreign& foreign : foreign_) step(foreign.node, foreign.node + 1);
}

// Returns the residual in single precision.
template <>
const float* AggregationMultigrid::first_residual<float>() {
  return single_.r.data();
}
template <>
const float* AggregationMultigrid::first_residual<double>() {
  std::copy(wide_.r.begin(), wide_.r.end(), single_.r.begin());
  return single_.r.data();
}

template <class Scalar>
double AggregationMultigrid::solve(const Team& team, const RowLayout& layout, BinnedSum& sum) {
  MultigridLevel& first = levels_[0];
  const float* r = first_residual<Scalar>();
  std::array<BinnedSum, n_sums> sums = {sum, BinnedSum{}};
  if (replicated_ == 0) {
    std::copy_n(r + 4 * static_cast<std::size_t>(owned_.begin),
                4 * static_cast<std::size_t>(owned_.end - owned_.begin),
                first.residual.begin() + 4 * static_cast<std::size_t>(owned_.begin));
  } else {
    first.smooth(team, r);
    for (const Foreign& foreign : foreign_) first.smooth_node(foreign.node, r);
    first.multiply(team);
    first.restrict_residual(team, r, levels_[1].residual.data());
    sums[1] = first.smoothed_product(r);
  }
  gather_residual(layout, sums.data());
  cycle(team, replicated_);
  if (replicated_ > 0) {
    const float* coarse = levels_[1].solution.data();
    first.prolong(team, coarse);
    for (const Foreign& foreign : foreign_)
      first.add_to_node(foreign.node, coarse + 4 * static_cast<std::size_t>(foreign.parent));
    first.multiply(team);
    first.smooth_again(team, r);
  }
  sum = sums[0];
  double product = sums[1].value();
  const MultigridLevel& level = levels_[replicated_];
  for (std::size_t i = 0; i < 4 * static_cast<std::size_t>(level.n_nodes()); ++i)
    product += static_cast<double>(level.residual[i]) * static_cast<double>(level.solution[i]);
  return product;
}

BinnedSum AggregationMultigrid::correction_product() const {
  BinnedSum sum;
  for (Index block = owned_.first_parent; block < owned_.last_parent; ++block)
    sum.add(LOOMSTONE_WIDEST(dots)(aggregates_.block_start[block],
                                   aggregates_.block_start[block + 1], single_.r.data(),
                                   correction()));
  return sum;
}

// Gathers the residual of the first replicated level. Each rank sends its `sums` in the same
// message. Replaces `sums` by their totals over all ranks.
void AggregationMultigrid::gather_residual(const RowLayout& layout, BinnedSum* sums) {
  if (layout.single()) return;
  const Communicator& ranks = layout.communicator();
  float* residual = levels_[replicated_].residual.data();
  constexpr std::size_t sums_bytes = n_sums * sizeof(BinnedSum);
  std::byte* mine = gathered_.data() + part_starts_[ranks.rank()];
  const auto rows_of = [&](int rank) {
    return residual + 4 * static_cast<std::size_t>(first_replicated_[rank]);
  };
  std::memcpy(mine, sums, sums_bytes);
  std::memcpy(mine + sums_bytes, rows_of(ranks.rank()),
              part_starts_[ranks.rank() + 1] - part_starts_[ranks.rank()] - sums_bytes);
  ranks.gather_all(gathered_.data(), part_starts_);
  for (int rank = 0; rank < ranks.size(); ++rank) {
    if (rank == ranks.rank()) continue;
    const std::byte* part = gathered_.data() + part_starts_[rank];
    for (int i = 0; i < n_sums; ++i) {
      BinnedSum other;
      std::memcpy(&other, part + i * sizeof other, sizeof other);
      sums[i].add(other);
    }
    std::memcpy(rows_of(rank), part + sums_bytes,
                part_starts_[rank + 1] - part_starts_[rank] - sums_bytes);
  }
}

// V-cycle on a replicated level.
void AggregationMultigrid::cycle(const Team& team, std::size_t l) {
  MultigridLevel& level = levels_[l];
  const float* r = level.residual.data();
  if (!level.is_coarsest()) {
    level.smooth(team, r);
    level.multiply(team);
    level.restrict_residual(team, r, levels_[l + 1].residual.data());
    cycle(team, l + 1);
    level.prolong(team, levels_[l + 1].solution.data());
    level.multiply(team);
    level.smooth_again(team, r);
    return;
  }
  const Index n = level.n_nodes();
  Vector values(3 * n);
  for (Index i = 0; i < n; ++i)
    values.segment<3>(3 * i) = Eigen::Map<const Eigen::Vector3f>(r + 4 * i).cast<double>();
  coarsest_.solveInPlace(values);
  for (Index i = 0; i < n; ++i)
    Eigen::Map<Eigen::Vector3f>(level.solution.data() + 4 * i) =
        values.segment<3>(3 * i).cast<float>();
}

template void AggregationMultigrid::sum_over_slots(Index, Index, const Index*, const float*,
                                                   std::vector<float>&) const;
template void AggregationMultigrid::sum_over_slots(Index, Index, const Index*, const double*,
                                                   std::vector<double>&) const;
template void AggregationMultigrid::take_step(float);
template void AggregationMultigrid::take_step(double);
template double AggregationMultigrid::solve<float>(const Team&, const RowLayout&, BinnedSum&);
template double AggregationMultigrid::solve<double>(const Team&, const RowLayout&, BinnedSum&);

}  // namespace loomstone
