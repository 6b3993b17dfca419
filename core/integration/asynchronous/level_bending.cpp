#include "core/integration/asynchronous/level_bending.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/cloth/bending/bending_subset.h"

namespace loomstone {

namespace {

// Triangles of a patch. Triangles that follow one another are neighbours on the mesh. Our choice:
// small enough for graded meshes, large enough that most neighbours are in the same patch.
constexpr Index patch = 64;

double longest_step(double eigenvalue, double damping, double safety) {
  if (!(eigenvalue > 0.0)) return std::numeric_limits<double>::infinity();
  return std::sqrt(damping * damping + 4.0 * safety * safety / eigenvalue) - damping;
}

}  // namespace

BendingMesh::BendingMesh(const ClothModel& model, const ClothModel::BendingPart& part)
    : part(part), edges(edge_table(model.n_vertices, part.setup.triangles)) {
  const Triangles& own = part.setup.triangles;
  for (Index t = 0; t < model.triangles.rows(); ++t) {
    const auto next = static_cast<Index>(triangles.size());
    if (next < own.rows() && own.row(next) == model.triangles.row(t)) triangles.push_back(t);
  }
}

BendingGroup::BendingGroup(const BendingMesh& mesh, const std::vector<Index>& acting) {
  BendingSubset subset = bending_subset(mesh.part.setup, mesh.edges, acting);
  vertices_ = std::move(subset.vertices);
  bending_ = mesh.part.element == BendingElement::Hinge ? make_hinge_bending(subset.setup)
                                                        : make_midedge_bending(subset.setup);
  for (const double beta : subset.setup.damping) damping_ = std::max(damping_, beta);
  x_ = Points::Zero(static_cast<Index>(vertices_.size()), 3);
  last_ = rate_ = force_ = x_;
}

double BendingGroup::eigenvalue(const Vector& mass) const {
  Vector own(static_cast<Index>(vertices_.size()));
  for (std::size_t i = 0; i < vertices_.size(); ++i)
    own[static_cast<Index>(i)] = mass[vertices_[i]];
  return bending_->largest_eigenvalue(own);
}

void BendingGroup::kick(const Team& team, const Kick& kick, const Vector& inverse_mass,
                        const Points& x, Points& v) {
  const auto n = static_cast<Index>(vertices_.size());
  parallel_for(team, n, [&](Index i) {
    x_.row(i) = x.row(vertices_[i]);
    force_.row(i).setZero();
    if (damping_ == 0.0) return;
    if (kick.start)
      rate_.row(i) = v.row(vertices_[i]);
    else
      rate_.row(i) = (x_.row(i) - last_.row(i)) / kick.since;
    last_.row(i) = x_.row(i);
  });
  bending_->add_forces(team, x_, rate_, 0, n, force_);
  parallel_for(team, n, [&](Index i) {
    v.row(vertices_[i]) += kick.h * inverse_mass[vertices_[i]] * force_.row(i);
  });
}

Vector bending_steps(const ClothModel& model, const std::vector<BendingMesh>& meshes,
                     double safety) {
  Vector steps = Vector::Constant(model.triangles.rows(), std::numeric_limits<double>::infinity());
  for (const BendingMesh& mesh : meshes) {
    const auto m = static_cast<Index>(mesh.triangles.size());
    for (Index first = 0; first < m; first += patch) {
      const Index last = std::min(m, first + patch);
      std::vector<Index> acting(last - first);
      std::iota(acting.begin(), acting.end(), first);
      // Neighbours add to the stiffness at the vertices of the patch.
      add_neighbours(mesh.edges, acting);
      const BendingGroup group(mesh, acting);
      const double step = longest_step(group.eigenvalue(model.mass), group.damping(), safety);
      for (Index i = first; i < last; ++i) steps[mesh.triangles[i]] = step;
    }
  }
  return steps;
}

void equalise_patches(Vector& steps) {
  const auto m = static_cast<Index>(steps.size());
  for (Index first = 0; first < m; first += patch) {
    const Index n = std::min(patch, m - first);
    steps.segment(first, n).setConstant(steps.segment(first, n).minCoeff());
  }
}

LevelGroups::LevelGroups(const std::vector<BendingMesh>& meshes,
                         const std::vector<std::uint8_t>& levels) {
  const int finest = *std::max_element(levels.begin(), levels.end());
  for (const BendingMesh& mesh : meshes)
    for (int wanted = finest; wanted >= 0; --wanted) {
      std::vector<Index> acting;
      for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        if (levels[mesh.triangles[i]] == wanted) acting.push_back(static_cast<Index>(i));
      if (acting.empty()) continue;
      groups.emplace_back(mesh, acting);
      level.push_back(static_cast<std::uint8_t>(wanted));
    }
}

}  // namespace loomstone
