#include "core/cloth/membrane/membrane.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

#include "core/base/message.h"
#include "core/base/simd.h"
#include "core/cloth/membrane/membrane_kernels.h"

namespace loomstone {

namespace {
constexpr Index batches_per_range = 32;
}  // namespace

MembraneConstants membrane_constants(const ClothMaterial& material, const std::string& where) {
  const double nu12 = material.poisson;
  const double nu21 =
      nu12 * material.warp_stiffness / material.weft_stiffness;  // nu21 E1 = nu12 E2
  const double determinant = 1.0 - nu12 * nu21;
  if (!(determinant > 0.0)) {
    fail<InvalidInput>(
        "{}.poisson must keep the energy positive definite (poisson^2 * warp_stiffness / "
        "weft_stiffness < 1), got {}; lower it below {:.6g}",
        where, nu12, std::sqrt(material.weft_stiffness / material.warp_stiffness));
  }
  if (material.viscosity_dilation + material.viscosity_shear < 0.0) {
    fail<InvalidInput>(
        "{0}.viscosity_dilation must be >= -viscosity_shear [N s/m], or viscous forces add energy; "
        "got {1}; raise {0}.viscosity_dilation to {2} or more",
        where, material.viscosity_dilation, -material.viscosity_shear);
  }
  // These are the constants of (2.22) in [Thomaszewski2010], with E1 along weft and a12 = nu12 E2 /
  // (1 - nu12 nu21).
  return {material.weft_stiffness / determinant,
          material.warp_stiffness / determinant,
          nu12 * material.warp_stiffness / determinant,
          material.shear_stiffness,
          material.viscosity_dilation,
          material.viscosity_shear};
}

Membrane::Membrane(Index n_vertices, const Triangles& triangles,
                   const std::vector<Corners2>& corners, const MembraneConstantsOf& constants)
    : Membrane(triangles, corners, constants, n_vertices,
               {{0, n_vertices}, {0, static_cast<Index>(triangles.rows())}}) {}

Membrane::Membrane(const Triangles& triangles, const std::vector<Corners2>& corners,
                   const MembraneConstantsOf& constants, Index n_vertices, MeshPart part)
    : n_triangles_(static_cast<Index>(triangles.rows())) {
  store(triangles, part);
  make_tables(triangles, corners, constants);
  make_slots(n_vertices, part.rows);
  element_forces_.resize(stored_.size() * membrane::force_stride);
  element_strains_.resize(stored_.size() * membrane::strain_stride);
}

// Lists the batches with a triangle of the part.
void Membrane::store(const Triangles& triangles, MeshPart part) {
  for (Index t = 0; t < n_triangles_; ++t) {
    if (!part.contains(triangles, t)) continue;
    if (stored_.empty() || stored_.back() != t / n_lanes) stored_.push_back(t / n_lanes);
  }
  stored_.shrink_to_fit();
}

void Membrane::make_tables(const Triangles& triangles, const std::vector<Corners2>& corners,
                           const MembraneConstantsOf& constants) {
  corners_.assign(stored_.size() * membrane::corner_stride, 0);
  gradients_.assign(stored_.size() * membrane::gradient_stride, 0.0);
  constants_.assign(stored_.size() * membrane::constant_stride, 0.0);
  for (std::size_t i = 0; i < stored_.size() * n_lanes; ++i) {
    // Empty lanes repeat the last triangle, with zero area.
    const std::size_t batch = i / n_lanes, lane = i % n_lanes;
    const Index t = stored_[batch] * n_lanes + static_cast<Index>(lane);
    const Index source = std::min(t, n_triangles_ - 1);
    const Corners2& c = corners[source];
    const Vec2 e1 = (c.row(1) - c.row(0)).transpose(), e2 = (c.row(2) - c.row(0)).transpose();
    const double twice_area = e1.x() * e2.y() - e1.y() * e2.x();
    // Gradients of linear shape functions, (2.27)-(2.29) of [Thomaszewski2010]. They sum to zero.
    const Vec2 g1(e2.y() / twice_area, -e2.x() / twice_area),
        g2(-e1.y() / twice_area, e1.x() / twice_area);
    const Vec2 g0 = -(g1 + g2);
    const double values[6] = {g0.x(), g0.y(), g1.x(), g1.y(), g2.x(), g2.y()};
    for (int k = 0; k < 6; ++k)
      gradients_[membrane::gradient_stride * batch + n_lanes * k + lane] = values[k];
    for (int k = 0; k < 3; ++k)
      corners_[membrane::corner_stride * batch + n_lanes * k + lane] = triangles(source, k);
    if (t >= n_triangles_) continue;
    const MembraneConstants& m = constants(t);
    const double material[7] = {0.5 * twice_area, m.a11, m.a22, m.a12, m.g, m.lambda_d, m.mu_d};
    for (int k = 0; k < 7; ++k)
      constants_[membrane::constant_stride * batch + n_lanes * k + lane] = material[k];
  }
  viscous_ = constants.viscous();
}

// Lists, for each row of the part, where its forces are in element_forces_. The lists of other rows
// are empty.
void Membrane::make_slots(Index n_vertices, IndexRange rows) {
  const auto for_each_slot = [&](auto&& body) {
    for (Index place = 0; place < n_batches(); ++place)
      for (Index lane = 0; lane < std::min(n_lanes, n_triangles_ - stored_[place] * n_lanes);
           ++lane)
        for (int k = 0; k < 3; ++k) {
          const Index vertex = corners_[membrane::corner_stride * place + n_lanes * k + lane];
          if (rows.contains(vertex))
            body(vertex, place * membrane::force_stride + 3 * n_lanes * k + lane);
        }
  };
  slot_start_.assign(n_vertices + 1, 0);
  for_each_slot([&](Index vertex, Index) { ++slot_start_[vertex + 1]; });
  for (Index i = 0; i < n_vertices; ++i) slot_start_[i + 1] += slot_start_[i];
  slots_.resize(slot_start_[n_vertices]);
  std::vector<Index> fill(slot_start_.begin(), slot_start_.end() - 1);
  for_each_slot([&](Index vertex, Index slot) { slots_[fill[vertex]++] = slot; });
}

void Membrane::add_limits(const std::vector<LimitModes>& modes) {
  limits_.resize(stored_.size() * membrane::limit_stride);
  for (Index i = 0; i < n_batches() * n_lanes; ++i)
    for (int k = 0; k < 3; ++k) {
      const Index t = stored_[i / n_lanes] * n_lanes + i % n_lanes;
      const LimitMode& mode = modes[std::min(t, n_triangles_ - 1)][k];
      const double values[8] = {mode.d11,  mode.d22,     mode.d12,      mode.low,
                                mode.high, mode.far_low, mode.far_high, mode.modulus};
      double* table = limits_.data() +
                      membrane::limit_stride * static_cast<std::size_t>(i / n_lanes) +
                      membrane::mode_stride * k + i % n_lanes;
      for (int e = 0; e < 8; ++e) table[n_lanes * e] = values[e];
    }
}

void Membrane::select_rows(Index begin, Index end) {
  if (begin == begin_ && end == end_) return;
  begin_ = begin, end_ = end;
  batches_.clear();
  for (Index b = 0; b < n_batches(); ++b) {
    const Index* c = corners_.data() + membrane::corner_stride * static_cast<std::size_t>(b);
    if (std::any_of(c, c + membrane::corner_stride, [&](Index v) { return v >= begin && v < end; }))
      batches_.push_back(b);
  }
}

double Membrane::energy(const Team& team, const Points& x) {
  const Index n_blocks = (n_triangles_ + rows_per_block - 1) / rows_per_block;
  std::vector<double> sums(n_blocks);
  sum_energies(team, x, {0, n_blocks}, sums);
  return std::accumulate(sums.begin(), sums.end(), 0.0);
}

void Membrane::sum_energies(const Team& team, const Points& x, IndexRange blocks,
                            std::vector<double>& sums) {
  const membrane::Tables tables = this->tables();
  const auto triangles_before = [&](Index block) {
    return std::min(n_triangles_, block * rows_per_block);
  };
  parallel_ranges(team, blocks.end - blocks.begin, 2, [&](Index first, Index last) {
    const Index begin = triangles_before(blocks.begin + first),
                end = triangles_before(blocks.begin + last);
    std::vector<Index> places((end - begin + n_lanes - 1) / n_lanes);
    std::iota(places.begin(), places.end(), place_of(begin / n_lanes));
    membrane::strains(tables, places.data(), static_cast<Index>(places.size()), x.data(),
                      element_strains_.data());
    for (Index block = blocks.begin + first; block < blocks.begin + last; ++block) {
      double sum = 0.0;
      for (Index t = triangles_before(block); t < triangles_before(block + 1); ++t)
        sum += element_strains_[membrane::strain_stride *
                                    static_cast<std::size_t>(places[(t - begin) / n_lanes]) +
                                3 * n_lanes + t % n_lanes];
      sums[block] = sum;
    }
  });
}

Membrane::Neglected Membrane::neglected(const double* start, const double* end,
                                        Index first_triangle, Index last_triangle) const {
  constexpr Index batches_at_once = 16;
  const membrane::Tables tables = this->tables();
  double strains[batches_at_once * membrane::neglected_stride];
  Neglected found;
  for (Index t = first_triangle; t < last_triangle;) {
    const Index batch = t / n_lanes;
    const Index n = std::min(batches_at_once, (last_triangle - 1) / n_lanes + 1 - batch);
    membrane::neglected_strains(tables, {place_of(batch), n}, start, end, strains);
    for (const Index stop = std::min(last_triangle, (batch + n) * n_lanes); t < stop; ++t) {
      const double* of = strains + membrane::neglected_stride * (t / n_lanes - batch) + t % n_lanes;
      found.strain = std::max(found.strain, of[0]);
      found.energy += of[n_lanes];
      found.elastic += of[2 * n_lanes];
    }
  }
  return found;
}

void Membrane::add_forces(const Team& team, const Points& x, const Points* v, Index begin,
                          Index end, RowsOut force) {
  select_rows(begin, end);
  const membrane::Tables tables = this->tables();
  const double* velocity = v && viscous_ ? v->data() : nullptr;
  parallel_ranges(team, static_cast<Index>(batches_.size()), batches_per_range,
                  [&](Index first, Index last) {
                    membrane::forces(tables, batches_.data() + first, last - first, x.data(),
                                     velocity, element_forces_.data());
                  });
  parallel_for(team, end - begin, [&](Index i) {
    const Index row = begin + i;
    double sum[3] = {0.0, 0.0, 0.0};
    for (Index s = slot_start_[row]; s < slot_start_[row + 1]; ++s) {
      const double* f = element_forces_.data() + slots_[s];
      sum[0] += f[0], sum[1] += f[n_lanes], sum[2] += f[2 * n_lanes];
    }
    for (int d = 0; d < 3; ++d) force(row, d) += sum[d];
  });
}

namespace {
constexpr Index no_element = 0;  // offset of a block of zeros in a chunk's scratch memory
constexpr Index first_element = 16;
}  // namespace

// At most two triangles share a mesh edge, and they traverse it in opposite directions. The matrix
// block of the edge is therefore the block of one triangle plus the transposed block of the other.
// This function finds these two sources for each matrix block. If a source does not exist, for
// example at a boundary edge, a block of zeros replaces it.
void Membrane::locate_rows(const BlockMatrix& matrix, Index begin, Index end) {
  if (matrix.columns().data() == located_columns_ && matrix.n_blocks() == located_blocks_ &&
      begin == located_begin_ && end == located_end_)
    return;
  located_columns_ = matrix.columns().data(), located_blocks_ = matrix.n_blocks();
  located_begin_ = begin, located_end_ = end;
  chunk_start_.assign(1, 0);
  chunk_batches_.clear(), diagonal_.clear();
  row_start_.assign(1, 0);
  sources_.clear();
  const Index first_block = matrix.row_start()[begin];
  std::vector<Index> place(n_batches());
  for (Index first = begin; first < end; first += rows_per_block) {
    const Index last = std::min(end, first + rows_per_block);
    for (Index s = slot_start_[first]; s < slot_start_[last]; ++s)
      chunk_batches_.push_back(slots_[s] / membrane::force_stride);
    const auto list = chunk_batches_.begin() + chunk_start_.back();
    std::sort(list, chunk_batches_.end());
    chunk_batches_.erase(std::unique(list, chunk_batches_.end()), chunk_batches_.end());
    for (auto b = list; b < chunk_batches_.end(); ++b) place[*b] = static_cast<Index>(b - list);
    chunk_start_.push_back(static_cast<Index>(chunk_batches_.size()));
    for (Index row = first; row < last; ++row) {
      row_start_.push_back(matrix.row_start()[row + 1] - first_block);
      diagonal_.push_back(matrix.diagonal()[row] - first_block);
      sources_.resize(2 * static_cast<std::size_t>(row_start_.back()), no_element);
      for (Index s = slot_start_[row]; s < slot_start_[row + 1]; ++s) {
        const Index batch = slots_[s] / membrane::force_stride,
                    rest = slots_[s] % membrane::force_stride;
        const Index corner = rest / (3 * n_lanes), lane = rest % n_lanes;
        for (const Index other : {(corner + 1) % 3, (corner + 2) % 3}) {
          // A triangle stores one block for each pair of corners (p, p + 1). The block of
          // (p + 1, p) is its transpose.
          const bool transposed = other == (corner + 2) % 3;
          const Index position =
              matrix.find(row, corners_[membrane::corner_stride * batch + n_lanes * other + lane]) -
              first_block;
          Index& source = sources_[2 * static_cast<std::size_t>(position) + (transposed ? 1 : 0)];
          assert(source == no_element && "two triangles run along an edge in the same direction");
          source = first_element + membrane::block_stride * place[batch] +
                   membrane::pair_stride * (transposed ? other : corner) +
                   membrane::lane_stride * lane;
        }
      }
    }
  }
}

void Membrane::set_chunk(Index chunk, const Points& x, JacobianTerms terms, AlignedDoubles& scratch,
                         BlockMatrix& matrix) const {
  const Index n = chunk_start_[chunk + 1] - chunk_start_[chunk];
  const std::size_t size = first_element + static_cast<std::size_t>(n) * membrane::block_stride;
  if (scratch.size() < size) scratch.resize(size);
  std::fill_n(scratch.begin(), first_element, 0.0);
  membrane::blocks(tables(), chunk_batches_.data() + chunk_start_[chunk], n, x.data(), terms,
                   scratch.data() + first_element);
  const Index first = chunk * rows_per_block,
              last = std::min(located_end_ - located_begin_, first + rows_per_block);
  membrane::rows(last - first, row_start_.data() + first, diagonal_.data() + first, sources_.data(),
                 scratch.data(), matrix.block(matrix.row_start()[located_begin_]));
}

void Membrane::set_jacobian(const Team& team, const Points& x, JacobianTerms terms, Index begin,
                            Index end, BlockMatrix& matrix) {
  locate_rows(matrix, begin, end);
  parallel_ranges(team, static_cast<Index>(chunk_start_.size()) - 1, 1,
                  [&](Index first, Index last) {
                    AlignedDoubles scratch;
                    for (Index chunk = first; chunk < last; ++chunk)
                      set_chunk(chunk, x, terms, scratch, matrix);
                  });
}

void Membrane::strain(const Team& team, const Points& x, IndexRange triangles, Points& green,
                      Vector& stretch) {
  const membrane::Tables tables = this->tables();
  const Index n = triangles.end - triangles.begin,
              first_place = place_of(triangles.begin / n_lanes);
  green.resize(n, 3);
  stretch.resize(n);
  parallel_ranges(
      team, (n + n_lanes - 1) / n_lanes, batches_per_range, [&](Index first, Index last) {
        std::vector<Index> list(last - first);
        std::iota(list.begin(), list.end(), first_place + first);
        membrane::strains(tables, list.data(), last - first, x.data(), element_strains_.data());
        for (Index t = first * n_lanes; t < std::min(n, last * n_lanes); ++t) {
          const double* e =
              element_strains_.data() +
              membrane::strain_stride * static_cast<std::size_t>(first_place + t / n_lanes) +
              t % n_lanes;
          green.row(t) << e[0], e[n_lanes], e[2 * n_lanes];
          stretch[t] = e[4 * n_lanes];
        }
      });
}

}  // namespace loomstone
