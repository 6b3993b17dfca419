#include "core/cloth/membrane.h"

#include <algorithm>
#include <map>
#include <sstream>

#include "core/base/error.h"
#include "core/cloth/membrane_kernels.h"

namespace loomstone {

namespace {
constexpr Index lanes = 8;
constexpr Index batches_per_range = 32;

membrane::Tables tables_of(const std::vector<Index>& corners, const std::vector<double>& gradients,
                           const std::vector<double>& constants) {
  return {corners.data(), gradients.data(), constants.data()};
}
}  // namespace

MembraneConstants membrane_constants(const ClothMaterial& material, const std::string& where) {
  const double nu12 = material.poisson;
  const double nu21 = nu12 * material.warp_stiffness / material.weft_stiffness;  // nu21 E1 = nu12 E2
  const double determinant = 1.0 - nu12 * nu21;
  if (!(determinant > 0.0)) {
    std::ostringstream out;
    out << where << ".poisson must keep the energy positive definite (poisson^2 * warp_stiffness / weft_stiffness < 1), got "
        << nu12 << "; lower it below " << std::sqrt(material.weft_stiffness / material.warp_stiffness);
    throw InvalidInput(out.str());
  }
  if (material.viscosity_dilation + material.viscosity_shear < 0.0) {
    std::ostringstream out;
    out << where << ".viscosity_dilation must be >= -viscosity_shear [N s/m], got " << material.viscosity_dilation
        << "; viscous forces would feed energy";
    throw InvalidInput(out.str());
  }
  // method.md 1.1: a11 with E1 and the strain along weft; a12 = nu12 E2 / (1 - nu12 nu21).
  return {material.weft_stiffness / determinant, material.warp_stiffness / determinant,
          nu12 * material.warp_stiffness / determinant, material.shear_stiffness, material.viscosity_dilation,
          material.viscosity_shear};
}

Membrane::Membrane(Index n_vertices, const Triangles& triangles, const std::vector<Corners2>& corners,
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
    const Index source = std::min(t, n_triangles_ - 1);  // empty lanes repeat the last triangle with zero area
    const std::size_t batch = t / lanes, lane = t % lanes;
    const Corners2& c = corners[source];
    const Vec2 e1 = (c.row(1) - c.row(0)).transpose(), e2 = (c.row(2) - c.row(0)).transpose();
    const double twice_area = e1.x() * e2.y() - e1.y() * e2.x();
    // Gradients of linear shape functions (2.27)-(2.29); they add up to zero.
    const Vec2 g1(e2.y() / twice_area, -e2.x() / twice_area), g2(-e1.y() / twice_area, e1.x() / twice_area);
    const Vec2 g0 = -(g1 + g2);
    const double values[6] = {g0.x(), g0.y(), g1.x(), g1.y(), g2.x(), g2.y()};
    for (int k = 0; k < 6; ++k) gradients_[membrane::gradient_stride * batch + lanes * k + lane] = values[k];
    for (int k = 0; k < 3; ++k) corners_[membrane::corner_stride * batch + lanes * k + lane] = triangles(source, k);
    if (t >= n_triangles_) continue;
    area_[t] = 0.5 * twice_area;
    const MembraneConstants& m = constants[t];
    const double material[7] = {area_[t], m.a11, m.a22, m.a12, m.g, m.lambda_d, m.mu_d};
    for (int k = 0; k < 7; ++k) constants_[membrane::constant_stride * batch + lanes * k + lane] = material[k];
    viscous_ = viscous_ || m.lambda_d != 0.0 || m.mu_d != 0.0;
  }
  for (Index t = 0; t < n_triangles_; ++t)
    for (int k = 0; k < 3; ++k) ++slot_start_[triangles(t, k) + 1];
  for (Index i = 0; i < n_vertices; ++i) slot_start_[i + 1] += slot_start_[i];
  slots_.resize(slot_start_[n_vertices]);
  std::vector<Index> fill(slot_start_.begin(), slot_start_.end() - 1);
  for (Index t = 0; t < n_triangles_; ++t)
    for (int k = 0; k < 3; ++k)
      slots_[fill[triangles(t, k)]++] = (t / lanes) * membrane::force_stride + 3 * lanes * k + t % lanes;
  element_forces_.resize(static_cast<std::size_t>(n_batches_) * membrane::force_stride);
  element_strains_.resize(static_cast<std::size_t>(n_batches_) * membrane::strain_stride);
}

void Membrane::select_rows(Index begin, Index end) {
  if (begin == begin_ && end == end_) return;
  begin_ = begin, end_ = end;
  batches_.clear();
  for (Index b = 0; b < n_batches_; ++b) {
    const Index* c = corners_.data() + membrane::corner_stride * static_cast<std::size_t>(b);
    if (std::any_of(c, c + membrane::corner_stride, [&](Index v) { return v >= begin && v < end; })) batches_.push_back(b);
  }
}

double Membrane::energy(const Team& team, const Points& x) {
  Points green;
  Vector stretch;
  strain(team, x, green, stretch);
  return parallel_sum(team, n_triangles_, [&](Index t) {
    return element_strains_[membrane::strain_stride * static_cast<std::size_t>(t / lanes) + 3 * lanes + t % lanes];
  });
}

void Membrane::add_forces(const Team& team, const Points& x, const Points* v, Index begin, Index end, Points& force) {
  select_rows(begin, end);
  const auto tables = tables_of(corners_, gradients_, constants_);
  const double* velocity = v && viscous_ ? v->data() : nullptr;
  parallel_ranges(team, static_cast<Index>(batches_.size()), batches_per_range, [&](Index first, Index last) {
    membrane::forces(tables, batches_.data() + first, last - first, x.data(), velocity, element_forces_.data());
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

// For every off-diagonal block of the rows, the at most two triangles that share the edge. Found once per pattern.
void Membrane::locate_blocks(const BlockMatrix& matrix, Index begin, Index end) {
  if (matrix.columns().data() == located_columns_ && matrix.n_blocks() == located_blocks_ && begin == located_begin_ &&
      end == located_end_)
    return;
  located_columns_ = matrix.columns().data(), located_blocks_ = matrix.n_blocks();
  located_begin_ = begin, located_end_ = end;
  source_start_.assign(end - begin + 1, 0);
  sources_.clear();
  for (Index row = begin; row < end; ++row) {
    std::map<Index, BlockSource> found;  // by position: ascending columns
    for (Index s = slot_start_[row]; s < slot_start_[row + 1]; ++s) {
      const Index batch = slots_[s] / membrane::force_stride, rest = slots_[s] % membrane::force_stride;
      const Index corner = rest / (3 * lanes), lane = rest % lanes, t = batch * lanes + lane;
      for (int step = 1; step <= 2; ++step) {
        const Index other = (corner + step) % 3;
        // Pair p holds block (p, p + 1); block (p + 1, p) is its transpose.
        const Index pair = step == 1 ? corner : other;
        const Index slot = 2 * (batch * membrane::block_stride + 72 * pair + lane) + (step == 1 ? 0 : 1);
        const Index position = matrix.find(row, triangles_(t, other));
        auto [item, fresh] = found.try_emplace(position, BlockSource{position, slot, -1});
        if (!fresh) item->second.second = slot;
      }
    }
    for (const auto& item : found) sources_.push_back(item.second);
    source_start_[row - begin + 1] = static_cast<Index>(sources_.size());
  }
}

namespace {
// Where the entries of a block lie, and those of its transpose.
constexpr Index entries[2][9] = {{0, 8, 16, 24, 32, 40, 48, 56, 64}, {0, 24, 48, 8, 32, 56, 16, 40, 64}};

inline void add_block(const double* elements, Index slot, double sum[9]) {
  const double* b = elements + slot / 2;
  const Index* entry = entries[slot % 2];
  for (int k = 0; k < 9; ++k) sum[k] += b[entry[k]];
}
}  // namespace

void Membrane::add_jacobian(const Team& team, const Points& x, JacobianKind kind, double scale_k, double scale_d,
                            Index begin, Index end, BlockMatrix& matrix) {
  select_rows(begin, end);
  locate_blocks(matrix, begin, end);
  element_blocks_.resize(static_cast<std::size_t>(n_batches_) * membrane::block_stride);
  const auto tables = tables_of(corners_, gradients_, constants_);
  parallel_ranges(team, static_cast<Index>(batches_.size()), batches_per_range, [&](Index first, Index last) {
    membrane::blocks(tables, batches_.data() + first, last - first, x.data(), kind == JacobianKind::Positive, scale_k,
                     scale_d, element_blocks_.data());
  });
  parallel_for(team, end - begin, [&](Index i) {
    const Index row = begin + i;
    double row_sum[9] = {};
    for (Index s = source_start_[i]; s < source_start_[i + 1]; ++s) {
      double sum[9] = {};
      add_block(element_blocks_.data(), sources_[s].first, sum);
      if (sources_[s].second >= 0) add_block(element_blocks_.data(), sources_[s].second, sum);
      double* target = matrix.block(sources_[s].position);
      for (int k = 0; k < 9; ++k) target[k] += sum[k], row_sum[k] += sum[k];
    }
    // A translation strains nothing: the diagonal block is minus the sum of the others.
    double* diagonal = matrix.block(matrix.diagonal()[row]);
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) diagonal[3 * c + r] -= 0.5 * (row_sum[3 * c + r] + row_sum[3 * r + c]);
  });
}

void Membrane::strain(const Team& team, const Points& x, Points& green, Vector& stretch) {
  const auto tables = tables_of(corners_, gradients_, constants_);
  green.resize(n_triangles_, 3);
  stretch.resize(n_triangles_);
  parallel_ranges(team, n_batches_, batches_per_range, [&](Index first, Index last) {
    std::vector<Index> list(last - first);
    for (Index b = first; b < last; ++b) list[b - first] = b;
    membrane::strains(tables, list.data(), last - first, x.data(), element_strains_.data());
    for (Index t = first * lanes; t < std::min(n_triangles_, last * lanes); ++t) {
      const double* e = element_strains_.data() + membrane::strain_stride * static_cast<std::size_t>(t / lanes) + t % lanes;
      green.row(t) << e[0], e[lanes], e[2 * lanes];
      stretch[t] = e[4 * lanes];
    }
  });
}

}  // namespace loomstone
