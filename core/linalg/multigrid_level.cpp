#include "core/linalg/multigrid_level.h"

#include <algorithm>

#include "core/base/sort_unique.h"
#include "core/linalg/flush_to_zero.h"
#include "core/linalg/quad.h"
#include "core/linalg/small.h"

namespace loomstone {

namespace {

constexpr Index slices_per_chunk = rows_per_block / 8;
constexpr Index parents_per_chunk = rows_per_block / 8;
// Smallest numbers of chunks in a task (see in_chunks()), in general and in multiply(). A chunk of
// nodes or slices contains rows_per_block nodes. A chunk of parents has about as many children.
constexpr Index chunks_a_task = 8;
constexpr Index chunks_of_product_a_task = 2;
// Damping of the Jacobi sweeps. With this factor, the sweeps converge if the eigenvalues of D^-1 A,
// with the diagonal blocks D, are below four. They are if each element or term couples at most four
// nodes. For elements or terms that couple more nodes, convergence is not guaranteed. If a V-cycle
// is indefinite, Preconditioner::complete() drops the multigrid correction.
constexpr double damping = 0.5;

std::size_t node_at(Index node) { return 4 * static_cast<std::size_t>(node); }

// Damped Jacobi sweep with the damped inverse diagonal blocks B. If t is null, z = B r. Otherwise t
// is A z, and z += B (r - t).
template <class>
LOOMSTONE_INLINE void sweep(Index first, Index last, const float* inverse, const float* r,
                            const float* t, float* z) {
  for (std::size_t i = first; i < static_cast<std::size_t>(last); ++i) {
    const float* b = inverse + 12 * i;
    FloatQuad v = quad_load(r + 4 * i), sum{};
    if (t) v -= quad_load(t + 4 * i), sum = quad_load(z + 4 * i);
    quad_store(z + 4 * i,
               ((sum + quad_load(b) * v[0]) + quad_load(b + 4) * v[1]) + quad_load(b + 8) * v[2]);
  }
}

// Returns the sum of z . (2 r - t) over the nodes [first, last).
template <class>
LOOMSTONE_INLINE double smoothed_dots(Index first, Index last, const float* r, const float* t,
                                      const float* z) {
  Quad sum{};
  for (std::size_t i = 4 * static_cast<std::size_t>(first); i < 4 * static_cast<std::size_t>(last);
       i += 4) {
    const FloatQuad here = quad_load(r + i);
    sum += __builtin_convertvector(quad_load(z + i), Quad) *
           __builtin_convertvector(here + (here - quad_load(t + i)), Quad);
  }
  return quad_sum(sum);
}

// Divides [begin, end) into chunks of `chunk` indices, of which only the last may be shorter. Calls
// body(first, last) in parallel for ranges of indices. A range consists of at least `least_a_task`
// chunks; only the last range may have fewer.
template <class Body>
void in_chunks(const Team& team, Index begin, Index end, Index chunk, Body&& body,
               Index least_a_task = chunks_a_task) {
  const Index n_chunks = (end - begin + chunk - 1) / chunk;
  parallel_ranges(team, n_chunks,
                  std::max(least_a_task, (n_chunks + team.threads - 1) / team.threads),
                  [&](Index first, Index last) {
                    const FlushToZero flush;
                    body(begin + first * chunk, std::min(end, begin + last * chunk));
                  });
}

}  // namespace

std::vector<std::pair<Index, Index>> MultigridLevel::group(std::vector<Index> first_children) {
  child_start = std::move(first_children);
  const std::vector<Index> parent = parents();
  std::vector<std::pair<Index, Index>> pairs;
  const std::vector<Index>&start = matrix.row_start(), &columns = matrix.columns();
  for (Index row = 0; row < n_nodes(); ++row)
    for (Index k = start[row]; k < start[row + 1]; ++k)
      if (parent[columns[k]] != parent[row]) pairs.emplace_back(parent[row], parent[columns[k]]);
  sort_unique(pairs);
  return pairs;
}

void MultigridLevel::find_targets(const BlockMatrix& next) {
  const std::vector<Index> parent = parents();
  const std::vector<Index>&start = matrix.row_start(), &columns = matrix.columns();
  target.resize(matrix.n_blocks());
  for (Index row = 0; row < n_nodes(); ++row)
    for (Index k = start[row]; k < start[row + 1]; ++k)
      target[k] = next.find(parent[row], parent[columns[k]]);
}

std::vector<Index> MultigridLevel::parents() const {
  std::vector<Index> parent(n_nodes());
  for (std::size_t node = 0; node + 1 < child_start.size(); ++node)
    std::fill(parent.begin() + child_start[node], parent.begin() + child_start[node + 1],
              static_cast<Index>(node));
  return parent;
}

void MultigridLevel::allocate(Range range, Index n_spare) {
  owned = range;
  for (auto* v : {&residual, &solution, &product}) v->assign(node_at(n_nodes() + n_spare), 0.0f);
  inverse.assign(12 * static_cast<std::size_t>(n_nodes()), 0.0f);
  if (is_coarsest()) return;
  slices.set_pattern(&matrix, {n_nodes(), owned.begin, owned.end});
  couplings.resize(slices);
}

void MultigridLevel::sum_blocks(BlockMatrix& next) const {
  const Index first = next.row_start()[owned.first_parent],
              last = next.row_start()[owned.last_parent];
  std::fill(next.block(first), next.block(last), 0.0);
  for (Index k = matrix.row_start()[owned.begin]; k < matrix.row_start()[owned.end]; ++k)
    add_block(matrix.block(k), next.block(target[k]));
}

bool MultigridLevel::invert_diagonal() {
  for (Index node = owned.begin; node < owned.end; ++node) {
    auto block = matrix.block_map(matrix.diagonal()[node]);
    if (block.isZero(0.0)) block.setIdentity();
    Mat3 inverted;
    if (!invert_positive_definite(block, inverted)) return false;
    float* out = inverse.data() + 12 * static_cast<std::size_t>(node);
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) out[4 * c + r] = static_cast<float>(damping * inverted(r, c));
  }
  return true;
}

void MultigridLevel::copy_couplings(const Team& team) {
  in_chunks(team, 0, slices.n_slices(), slices_per_chunk, [&](Index first, Index last) {
    couplings.set_slices(&matrix, nullptr, slices, first, last);
  });
}

void MultigridLevel::smooth(const Team& team, const float* r) {
  in_chunks(team, owned.begin, owned.end, rows_per_block, [&](Index first, Index last) {
    LOOMSTONE_WIDEST(sweep)(first, last, inverse.data(), r, nullptr, solution.data());
  });
}

void MultigridLevel::smooth_node(Index node, const float* r) {
  LOOMSTONE_WIDEST(sweep)(node, node + 1, inverse.data(), r, nullptr, solution.data());
}

void MultigridLevel::multiply(const Team& team) {
  in_chunks(
      team, 0, slices.n_slices(), slices_per_chunk,
      [&](Index first, Index last) {
        couplings.multiply_to_rows(slices, first, last, solution.data(), product.data());
      },
      chunks_of_product_a_task);
}

void MultigridLevel::smooth_again(const Team& team, const float* r) {
  in_chunks(team, owned.begin, owned.end, rows_per_block, [&](Index first, Index last) {
    LOOMSTONE_WIDEST(sweep)(first, last, inverse.data(), r, product.data(), solution.data());
  });
}

void MultigridLevel::restrict_residual(const Team& team, const float* r, float* coarse) const {
  in_chunks(team, owned.first_parent, owned.last_parent, parents_per_chunk,
            [&](Index first, Index last) {
              for (Index parent = first; parent < last; ++parent) {
                FloatQuad sum{};
                for (std::size_t i = node_at(child_start[parent]);
                     i < node_at(child_start[parent + 1]); i += 4)
                  sum += quad_load(r + i) - quad_load(product.data() + i);
                quad_store(coarse + node_at(parent), sum);
              }
            });
}

void MultigridLevel::prolong(const Team& team, const float* coarse) {
  in_chunks(team, owned.first_parent, owned.last_parent, parents_per_chunk,
            [&](Index first, Index last) {
              for (Index parent = first; parent < last; ++parent)
                for (Index child = child_start[parent]; child < child_start[parent + 1]; ++child)
                  add_to_node(child, coarse + node_at(parent));
            });
}

void MultigridLevel::add_to_node(Index node, const float* change) {
  float* z = solution.data() + node_at(node);
  quad_store(z, quad_load(z) + quad_load(change));
}

BinnedSum MultigridLevel::smoothed_product(const float* r) const {
  BinnedSum sum;
  for (Index parent = owned.first_parent; parent < owned.last_parent; ++parent)
    sum.add(LOOMSTONE_WIDEST(smoothed_dots)(child_start[parent], child_start[parent + 1], r,
                                            product.data(), solution.data()));
  return sum;
}

}  // namespace loomstone
