#include "core/cloth/membrane/membrane.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/base/message.h"
#include "core/cloth/membrane/membrane_kernels.h"

namespace loomstone {

namespace {
constexpr Index lanes = 8;
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
                   const std::vector<Corners2>& corners,
                   const std::vector<MembraneConstants>& constants)
    : n_vertices_(n_vertices),
      n_triangles_(static_cast<Index>(triangles.rows())),
      n_batches_((n_triangles_ + lanes - 1) / lanes),
      triangles_(triangles),
      corners_(static_cast<std::size_t>(n_batches_) * membrane::corner_stride, 0),
      gradients_(static_cast<std::size_t>(n_batches_) * membrane::gradient_stride, 0.0),
      constants_(static_cast<std::size_t>(n_batches_) * membrane::constant_stride, 0.0),
      area_(n_triangles_),
      slot_start_(n_vertices + 1, 0) {
  for (Index t = 0; t < n_batches_ * lanes; ++t) {
    // Empty lanes repeat the last triangle, with zero area.
    const Index source = std::min(t, n_triangles_ - 1);
    const std::size_t batch = t / lanes, lane = t % lanes;
    const Corners2& c = corners[source];
    const Vec2 e1 = (c.row(1) - c.row(0)).transpose(), e2 = (c.row(2) - c.row(0)).transpose();
    const double twice_area = e1.x() * e2.y() - e1.y() * e2.x();
    // Gradients of linear shape functions, (2.27)-(2.29) of [Thomaszewski2010]. They sum to zero.
    const Vec2 g1(e2.y() / twice_area, -e2.x() / twice_area),
        g2(-e1.y() / twice_area, e1.x() / twice_area);
    const Vec2 g0 = -(g1 + g2);
    const double values[6] = {g0.x(), g0.y(), g1.x(), g1.y(), g2.x(), g2.y()};
    for (int k = 0; k < 6; ++k)
      gradients_[membrane::gradient_stride * batch + lanes * k + lane] = values[k];
    for (int k = 0; k < 3; ++k)
      corners_[membrane::corner_stride * batch + lanes * k + lane] = triangles(source, k);
    if (t >= n_triangles_) continue;
    area_[t] = 0.5 * twice_area;
    const MembraneConstants& m = constants[t];
    const double material[7] = {area_[t], m.a11, m.a22, m.a12, m.g, m.lambda_d, m.mu_d};
    for (int k = 0; k < 7; ++k)
      constants_[membrane::constant_stride * batch + lanes * k + lane] = material[k];
    viscous_ = viscous_ || m.lambda_d != 0.0 || m.mu_d != 0.0;
  }
  for (Index t = 0; t < n_triangles_; ++t)
    for (int k = 0; k < 3; ++k) ++slot_start_[triangles(t, k) + 1];
  for (Index i = 0; i < n_vertices; ++i) slot_start_[i + 1] += slot_start_[i];
  slots_.resize(slot_start_[n_vertices]);
  std::vector<Index> fill(slot_start_.begin(), slot_start_.end() - 1);
  for (Index t = 0; t < n_triangles_; ++t)
    for (int k = 0; k < 3; ++k)
      slots_[fill[triangles(t, k)]++] =
          (t / lanes) * membrane::force_stride + 3 * lanes * k + t % lanes;
  element_forces_.resize(static_cast<std::size_t>(n_batches_) * membrane::force_stride);
  element_strains_.resize(static_cast<std::size_t>(n_batches_) * membrane::strain_stride);
}

void Membrane::add_limits(const std::vector<LimitModes>& modes) {
  limits_.resize(static_cast<std::size_t>(n_batches_) * membrane::limit_stride);
  for (Index t = 0; t < n_batches_ * lanes; ++t)
    for (int k = 0; k < 3; ++k) {
      const LimitMode& mode = modes[std::min(t, n_triangles_ - 1)][k];
      const double values[8] = {mode.d11,  mode.d22,     mode.d12,      mode.low,
                                mode.high, mode.far_low, mode.far_high, mode.modulus};
      double* table = limits_.data() +
                      membrane::limit_stride * static_cast<std::size_t>(t / lanes) +
                      membrane::mode_stride * k + t % lanes;
      for (int i = 0; i < 8; ++i) table[lanes * i] = values[i];
    }
}

void Membrane::select_rows(Index begin, Index end) {
  if (begin == begin_ && end == end_) return;
  begin_ = begin, end_ = end;
  batches_.clear();
  for (Index b = 0; b < n_batches_; ++b) {
    const Index* c = corners_.data() + membrane::corner_stride * static_cast<std::size_t>(b);
    if (std::any_of(c, c + membrane::corner_stride, [&](Index v) { return v >= begin && v < end; }))
      batches_.push_back(b);
  }
}

double Membrane::energy(const Team& team, const Points& x) {
  Points green;
  Vector stretch;
  strain(team, x, green, stretch);
  return parallel_sum(team, n_triangles_, [&](Index t) {
    return element_strains_[membrane::strain_stride * static_cast<std::size_t>(t / lanes) +
                            3 * lanes + t % lanes];
  });
}

Membrane::Neglected Membrane::neglected(const double* start, const double* end,
                                        Index first_triangle, Index last_triangle) const {
  constexpr Index batches_at_once = 16;
  const membrane::Tables tables = this->tables();
  double strains[batches_at_once * membrane::neglected_stride];
  Neglected found;
  for (Index t = first_triangle; t < last_triangle;) {
    const Index batch = t / lanes;
    const Index n = std::min(batches_at_once, (last_triangle - 1) / lanes + 1 - batch);
    membrane::neglected_strains(tables, {batch, n}, start, end, strains);
    for (const Index stop = std::min(last_triangle, (batch + n) * lanes); t < stop; ++t) {
      const double* of = strains + membrane::neglected_stride * (t / lanes - batch) + t % lanes;
      found.strain = std::max(found.strain, of[0]);
      found.energy += of[lanes];
      found.elastic += of[2 * lanes];
    }
  }
  return found;
}

void Membrane::add_forces(const Team& team, const Points& x, const Points* v, Index begin,
                          Index end, Points& force) {
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
      sum[0] += f[0], sum[1] += f[lanes], sum[2] += f[2 * lanes];
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
  std::vector<Index> place(n_batches_);
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
        const Index corner = rest / (3 * lanes), lane = rest % lanes;
        for (const Index other : {(corner + 1) % 3, (corner + 2) % 3}) {
          // A triangle stores one block for each pair of corners (p, p + 1). The block of
          // (p + 1, p) is its transpose.
          const bool transposed = other == (corner + 2) % 3;
          const Index position =
              matrix.find(row, triangles_(batch * lanes + lane, other)) - first_block;
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

void Membrane::strain(const Team& team, const Points& x, Points& green, Vector& stretch) {
  const membrane::Tables tables = this->tables();
  green.resize(n_triangles_, 3);
  stretch.resize(n_triangles_);
  parallel_ranges(team, n_batches_, batches_per_range, [&](Index first, Index last) {
    std::vector<Index> list(last - first);
    for (Index b = first; b < last; ++b) list[b - first] = b;
    membrane::strains(tables, list.data(), last - first, x.data(), element_strains_.data());
    for (Index t = first * lanes; t < std::min(n_triangles_, last * lanes); ++t) {
      const double* e = element_strains_.data() +
                        membrane::strain_stride * static_cast<std::size_t>(t / lanes) + t % lanes;
      green.row(t) << e[0], e[lanes], e[2 * lanes];
      stretch[t] = e[4 * lanes];
    }
  });
}

}  // namespace loomstone
