#include "core/integration/asynchronous/level_bending.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/cloth/bending/bending_subset.h"

namespace loomstone {

namespace {

// Largest number of triangles in a patch, which consists of consecutive triangles. Our choice:
// small enough that the triangles of a patch are about equally large in graded meshes, and large
// enough that most neighbours are in the same patch.
constexpr Index patch = 64;

double longest_step(double eigenvalue, double damping, double safety) {
  if (!(eigenvalue > 0.0)) return std::numeric_limits<double>::infinity();
  return std::sqrt(damping * damping + 4.0 * safety * safety / eigenvalue) - damping;
}

}  // namespace

BendingMesh::BendingMesh(const ClothModel& model, const ClothModel::BendingPart& part)
    : element(part.element),
      setup(model.setup_of(part)),
      edges(edge_table(model.n_vertices, setup.triangles)) {
  const Triangles& own = setup.triangles;
  for (Index t = 0; t < model.triangles.rows(); ++t) {
    const auto next = static_cast<Index>(triangles.size());
    if (next < own.rows() && own.row(next) == model.triangles.row(t)) triangles.push_back(t);
  }
}

BendingGroup::BendingGroup(const BendingMesh& mesh, const std::vector<Index>& acting,
                           const std::vector<double>& factors) {
  BendingSubset subset = bending_subset(mesh.setup, mesh.edges, acting);
  std::size_t next = 0;  // the subset lists its acting triangles in the order of `acting`
  for (std::size_t t = 0; t < subset.setup.acts.size() && !factors.empty(); ++t)
    if (subset.setup.acts[t]) subset.setup.rigidity[t] *= factors[next++];
  vertices_ = std::move(subset.vertices);
  bending_ = mesh.element == BendingElement::Hinge ? make_hinge_bending(subset.setup)
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
  const auto apply = [&] {
    parallel_for(team, n, [&](Index i) {
      v.row(vertices_[i]) += kick.h * inverse_mass[vertices_[i]] * force_.row(i);
    });
  };
  if (kick.start && damping_ == 0.0 && known_at(x)) return apply();
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
  known_ = true;
  apply();
}

// Returns true if force_ contains the forces at the positions x.
bool BendingGroup::known_at(const Points& x) const {
  for (std::size_t i = 0; i < vertices_.size() && known_; ++i)
    if (x_.row(static_cast<Index>(i)) != x.row(vertices_[i])) return false;
  return known_;
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
      // The bending of neighbours adds to the stiffness at the vertices of the patch.
      add_neighbours(mesh.edges, acting);
      const BendingGroup group(mesh, acting);
      const double step = longest_step(group.eigenvalue(model.mass), group.damping(), safety);
      for (Index i = first; i < last; ++i) steps[mesh.triangles[i]] = step;
    }
  }
  return steps;
}

Vector mean_of_patches(const Vector& steps) {
  const auto m = static_cast<Index>(steps.size());
  Vector mean(m);
  for (Index first = 0; first < m; first += patch) {
    const Index n = std::min(patch, m - first);
    mean.segment(first, n).setConstant(steps.segment(first, n).mean());
  }
  return mean;
}

LevelGroups::LevelGroups(const std::vector<BendingMesh>& meshes,
                         const std::vector<std::uint8_t>& levels) {
  const int finest = *std::max_element(levels.begin(), levels.end());
  for (const BendingMesh& mesh : meshes) {
    const auto& damping = mesh.setup.damping;
    const bool united = *std::max_element(damping.begin(), damping.end()) == 0.0;
    int coarser = -1;
    for (int own = 0; own <= finest; ++own) {
      std::vector<Index> acting;
      std::vector<double> factors;
      bool any = false;
      for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const int of_triangle = levels[mesh.triangles[i]];
        any = any || of_triangle == own;
        if (of_triangle < own || (of_triangle > own && !united)) continue;
        acting.push_back(static_cast<Index>(i));
        factors.push_back(std::ldexp(1.0, own - of_triangle));
      }
      if (!any) continue;
      groups_.push_back({BendingGroup(mesh, acting, factors), own, coarser});
      if (united) coarser = own;
    }
  }
}

}  // namespace loomstone
