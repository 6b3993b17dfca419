#include "core/cloth/displacement_error.h"

#include <algorithm>
#include <cmath>

namespace loomstone {

namespace {

constexpr Index triangles_per_block = 128, least_blocks_a_thread = 8;
// Lower bound of the kinetic energy of a cloth in the moving frame (see StepError::energy), as a
// fraction of that in the world frame [1]. Smaller values are rounding errors.
constexpr double rounding = 1e-14;
// A step resolves the motion of a cloth if implicit Euler removes less than this fraction of the
// kinetic energy of the cloth in the step [1].
constexpr double resolved = 0.1;

double area_of(const Corners2& corners) {
  const Vec2 e1 = (corners.row(1) - corners.row(0)).transpose(),
             e2 = (corners.row(2) - corners.row(0)).transpose();
  return 0.5 * (e1.x() * e2.y() - e1.y() * e2.x());
}

}  // namespace

DisplacementError::DisplacementError(const ClothModel& cloth, const Elasticity& elasticity,
                                     double gravity, const RowLayout& layout)
    : cloth_(cloth),
      membrane_(elasticity.membrane()),
      layout_(layout),
      end_(elasticity.unknown_positions()) {
  const Index n_cloths = static_cast<Index>(cloth.first_vertex.size()) - 1;
  scales_.resize(n_cloths);
  for (Index c = 0; c < n_cloths; ++c) {
    const Index first = cloth.first_triangle[c], last = cloth.first_triangle[c + 1];
    const Index first_vertex = cloth.first_vertex[c];
    const Index n_vertices = cloth.first_vertex[c + 1] - first_vertex;
    for (Index i = first_vertex; i < first_vertex + n_vertices; ++i) {
      scales_[c].mass += cloth.mass[i];
      if (cloth.prescribed[i]) scales_[c].mass_of_prescribed += cloth.mass[i];
    }
    double area = 0.0;
    for (Index t = first; t < last; ++t) area += area_of(cloth.corners[t]);
    const double length = std::sqrt(area);
    scales_[c].height = 0.5 * scales_[c].mass * gravity * length;
    scales_[c].fall_time = std::sqrt(length / gravity);
    // A cloth's vertices are divided among its blocks in proportion to the blocks' numbers of
    // triangles.
    const auto vertex_at = [&](Index triangle) {
      return first_vertex + static_cast<Index>(static_cast<std::int64_t>(n_vertices) *
                                               (triangle - first) / (last - first));
    };
    for (Index t = first; t < last;) {
      const Index end = std::min(last, (t / triangles_per_block + 1) * triangles_per_block);
      blocks_.push_back({c, t, end, vertex_at(t), vertex_at(end)});
      t = end;
    }
  }
  sums_.resize(blocks_.size());
  for (const Index triangle : first_triangles(cloth.triangles, layout)) {
    const auto before = [&](const Block& block) { return block.first_triangle < triangle; };
    const auto n = std::partition_point(blocks_.begin(), blocks_.end(), before) - blocks_.begin();
    offsets_.push_back(static_cast<std::size_t>(n) * sizeof(Sums));
  }
}

StepError DisplacementError::over(const Team& team, const Points& start, const Points& end,
                                  double h) {
  return evaluate(team, &start, end, 1.0, h);
}

StepError DisplacementError::at(const Team& team, const Points& v, double h) {
  return evaluate(team, nullptr, v, h, h);
}

StepError DisplacementError::evaluate(const Team& team, const Points* start, const Points& end,
                                      double time, double h) {
  gather(team, [&](const Block& block) { return sums_of(block, start, end); });
  if (start)
    end_.set(end);
  else
    end_.forget();
  StepError error;
  const double square = time * time;
  for (std::size_t b = 0; b < blocks_.size();) {
    const Scales& scales = scales_[blocks_[b].cloth];
    const Sums sums = total(b);
    error.strain = std::max(error.strain, square * sums.strain);
    const double energy = square / (h * h) * kinetic(sums, scales);
    error.energy = std::max(error.energy, square * square * sums.energy / std::max(energy, 1e-300));
  }
  return error;
}

std::vector<Damping> DisplacementError::damping(const Team& team, const Points& x1,
                                                const Points& v0, const Points& v1, double h) {
  const bool known = end_.at(x1);
  gather(team, [&](const Block& block) {
    Sums sums = vertex_sums(block, nullptr, v1);
    sums.elastic =
        known ? sums_[&block - blocks_.data()].elastic
              : membrane_.neglected(nullptr, x1.data(), block.first_triangle, block.last_triangle)
                    .elastic;
    for (Index i = block.first_vertex; i < block.last_vertex; ++i)
      if (!cloth_.prescribed[i])
        sums.energy += 0.5 * cloth_.mass[i] * (v1.row(i) - v0.row(i)).squaredNorm();
    return sums;
  });
  std::vector<Damping> of_cloths;
  for (std::size_t b = 0; b < blocks_.size();) {
    const Scales& scales = scales_[blocks_[b].cloth];
    const Sums sums = total(b);
    const double energy = kinetic(sums, scales);
    if (sums.energy < resolved * energy)
      of_cloths.push_back(
          {sums.energy / (h * (energy + sums.elastic + scales.height)), scales.fall_time});
  }
  return of_cloths;
}

template <class OfBlock>
void DisplacementError::gather(const Team& team, OfBlock&& of_block) {
  const int rank = layout_.communicator().rank();
  const Index first = static_cast<Index>(offsets_[rank] / sizeof(Sums));
  const Index n = static_cast<Index>(offsets_[rank + 1] / sizeof(Sums)) - first;
  parallel_for(
      team, n, [&](Index i) { sums_[first + i] = of_block(blocks_[first + i]); },
      least_blocks_a_thread);
  if (!layout_.single()) layout_.communicator().gather_all(sums_.data(), offsets_);
}

DisplacementError::Sums DisplacementError::total(std::size_t& block) const {
  const Index cloth = blocks_[block].cloth;
  Sums all;
  for (; block < blocks_.size() && blocks_[block].cloth == cloth; ++block) {
    const Sums& sums = sums_[block];
    all.strain = std::max(all.strain, sums.strain), all.energy += sums.energy;
    all.elastic += sums.elastic;
    all.squares += sums.squares, all.moment += sums.moment, all.prescribed += sums.prescribed;
  }
  return all;
}

double DisplacementError::kinetic(const Sums& sums, const Scales& scales) const {
  const Vec3 frame = scales.mass_of_prescribed > 0.0
                         ? Vec3(sums.prescribed / scales.mass_of_prescribed)
                         : Vec3(sums.moment / scales.mass);
  const double relative =
      sums.squares - 2.0 * frame.dot(sums.moment) + scales.mass * frame.squaredNorm();
  return 0.5 * std::max(relative, rounding * sums.squares);
}

DisplacementError::Sums DisplacementError::sums_of(const Block& block, const Points* start,
                                                   const Points& end) const {
  const Membrane::Neglected neglected = membrane_.neglected(
      start ? start->data() : nullptr, end.data(), block.first_triangle, block.last_triangle);
  Sums sums = vertex_sums(block, start, end);
  sums.strain = neglected.strain, sums.energy = neglected.energy, sums.elastic = neglected.elastic;
  return sums;
}

DisplacementError::Sums DisplacementError::vertex_sums(const Block& block, const Points* start,
                                                       const Points& end) const {
  Sums sums;
  for (Index i = block.first_vertex; i < block.last_vertex; ++i) {
    Vec3 u = end.row(i).transpose();
    if (start) u -= start->row(i).transpose();
    const Vec3 moment = cloth_.mass[i] * u;
    sums.squares += moment.dot(u);
    sums.moment += moment;
    if (cloth_.prescribed[i]) sums.prescribed += moment;
  }
  return sums;
}

}  // namespace loomstone
