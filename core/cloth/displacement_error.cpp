#include "core/cloth/displacement_error.h"

#include <algorithm>

namespace loomstone {

namespace {

constexpr Index triangles_per_block = 128, least_blocks_a_thread = 8;
// Kinetic energy below this fraction of the one in the world's frame is rounding of their
// difference [1].
constexpr double rounding = 1e-14;

}  // namespace

DisplacementError::DisplacementError(const ClothModel& cloth, const Membrane& membrane,
                                     const RowLayout& layout)
    : cloth_(cloth), membrane_(membrane), layout_(layout) {
  const Index n_cloths = static_cast<Index>(cloth.first_vertex.size()) - 1;
  masses_.resize(n_cloths);
  for (Index c = 0; c < n_cloths; ++c) {
    const Index first = cloth.first_triangle[c], last = cloth.first_triangle[c + 1];
    const Index first_vertex = cloth.first_vertex[c];
    const Index n_vertices = cloth.first_vertex[c + 1] - first_vertex;
    for (Index i = first_vertex; i < first_vertex + n_vertices; ++i) {
      masses_[c].all += cloth.mass[i];
      if (cloth.prescribed[i]) masses_[c].prescribed += cloth.mass[i];
    }
    // Vertices are split in proportion to triangles.
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
  const int n_ranks = layout.communicator().size();
  for (int rank = 0; rank <= n_ranks; ++rank)
    offsets_.push_back(blocks_.size() * rank / n_ranks * sizeof(Sums));
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
  const int rank = layout_.communicator().rank();
  const Index first = static_cast<Index>(offsets_[rank] / sizeof(Sums));
  const Index n = static_cast<Index>(offsets_[rank + 1] / sizeof(Sums)) - first;
  parallel_for(
      team, n, [&](Index i) { sums_[first + i] = sums_of(blocks_[first + i], start, end); },
      least_blocks_a_thread);
  if (!layout_.single()) layout_.communicator().gather_all(sums_.data(), offsets_);

  StepError error;
  const double square = time * time;
  for (std::size_t b = 0; b < blocks_.size();) {
    const Index c = blocks_[b].cloth;
    Sums all;
    for (; b < blocks_.size() && blocks_[b].cloth == c; ++b) {
      const Sums& sums = sums_[b];
      all.strain = std::max(all.strain, sums.strain), all.energy += sums.energy;
      all.squares += sums.squares, all.moment += sums.moment, all.prescribed += sums.prescribed;
    }
    error.strain = std::max(error.strain, square * all.strain);
    const Masses& mass = masses_[c];
    const Vec3 frame = mass.prescribed > 0.0 ? Vec3(all.prescribed / mass.prescribed)
                                             : Vec3(all.moment / mass.all);
    const double relative =
        all.squares - 2.0 * frame.dot(all.moment) + mass.all * frame.squaredNorm();
    const double kinetic =
        0.5 * square / (h * h) * std::max({relative, rounding * all.squares, 1e-300});
    error.energy = std::max(error.energy, square * square * all.energy / kinetic);
  }
  return error;
}

DisplacementError::Sums DisplacementError::sums_of(const Block& block, const Points* start,
                                                   const Points& end) const {
  const Membrane::Neglected neglected = membrane_.neglected(
      start ? start->data() : nullptr, end.data(), block.first_triangle, block.last_triangle);
  Sums sums;
  sums.strain = neglected.strain, sums.energy = neglected.energy;
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
