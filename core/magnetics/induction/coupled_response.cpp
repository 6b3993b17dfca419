#include "core/magnetics/induction/coupled_response.h"

#include <cmath>

namespace loomstone {

namespace {

// Tolerance of applied_field(): estimated error of the surface integral of (B.n) B, relative to the
// surface integral of (B.n)^2.
constexpr double refinement = 3e-3;

}  // namespace

CoupledResponse::CoupledResponse(const Team& team, const std::vector<SoftBody>& soft)
    : team_(team), soft_(soft) {
  for (std::size_t i = 0; i < soft.size(); ++i) {
    const Points& local = soft[i].shape->samples();
    world_.emplace_back(local.rows(), 3);
    place_points(soft[i].pose, local, world_[i]);
    rotations_.push_back(rotation_matrix(soft[i].pose.orientation));
  }
  for (std::size_t i = 0; i < soft.size(); ++i)
    for (std::size_t k = 0; k < soft.size(); ++k) {
      if (i == k) continue;
      if (soft[i].shape->sphere_degree() > 0 && soft[k].shape->sphere_degree() > 0)
        add_coaxial(i, k);
      if (soft[i].shape->panels() && soft[k].shape->panels()) add_fluxes(i, k);
    }
}

std::vector<Vector> CoupledResponse::received(const std::vector<MagneticBody>& hard,
                                              const Vec3& field,
                                              std::vector<AppliedField>& applied) const {
  std::vector<Vector> result;
  applied.resize(soft_.size());
  for (std::size_t i = 0; i < soft_.size(); ++i) {
    // B is used instead of mu0 H: if the pole of a magnet touches the body, the normal component of
    // B is the same on both sides of the contact, but that of mu0 H is not.
    if (const auto panels = soft_[i].shape->panels()) {
      applied[i] = applied_field(team_, *panels, {soft_[i].pose, hard, field}, refinement);
      result.push_back(applied[i].fluxes);
      continue;
    }
    Points b = magnetic_field(team_, hard, world_[i], "B");
    b.rowwise() += field.transpose();
    result.push_back(soft_[i].shape->received(b * rotations_[i]));
  }
  return result;
}

Vector CoupledResponse::received(std::size_t target, const std::vector<Vector>& charges) const {
  Vector part = Vector::Zero(charges[target].size());
  std::vector<MagneticBody> others;
  for (std::size_t k = 0; k < soft_.size(); ++k)
    if (k != target && !coaxial_.contains({target, k}) && !fluxes_.contains({target, k}))
      others.push_back({soft_[k].shape->source(charges[k]), soft_[k].pose});
  if (!others.empty())
    part = soft_[target].shape->received(magnetic_field(team_, others, world_[target], "B") *
                                         rotations_[target]);
  for (std::size_t k = 0; k < soft_.size(); ++k) {
    if (const auto found = coaxial_.find({target, k}); found != coaxial_.end())
      found->second.add(charges[k], part);
    if (const auto found = fluxes_.find({target, k}); found != fluxes_.end())
      found->second.add(team_, charges[k], part);
  }
  return part;
}

std::vector<MagneticBody> CoupledResponse::placed(const std::vector<Vector>& charges,
                                                  const std::vector<AppliedField>& applied) const {
  std::vector<MagneticBody> bodies;
  for (std::size_t i = 0; i < soft_.size(); ++i)
    bodies.push_back({soft_[i].shape->source(charges[i], applied[i]), soft_[i].pose});
  return bodies;
}

void CoupledResponse::add_coaxial(std::size_t target, std::size_t source) {
  const SoftBody &a = soft_[target], &b = soft_[source];
  if (a.pose.orientation != b.pose.orientation) return;
  const Vec3 away = in_axes(a.pose, b.pose.position);
  if (std::hypot(away.x(), away.y()) > 1e-13 * std::abs(away.z())) return;
  coaxial_.emplace(std::pair(target, source),
                   CoaxialTranslation(away.z(), b.shape->sphere_degree(), b.shape->radius(),
                                      a.shape->sphere_degree(), a.shape->radius()));
}

void CoupledResponse::add_fluxes(std::size_t target, std::size_t source) {
  fluxes_.emplace(std::pair(target, source),
                  MutualFluxes(team_, *soft_[target].shape->panels(),
                               relative_pose(soft_[target].pose, soft_[source].pose),
                               *soft_[source].shape->panels()));
}

}  // namespace loomstone
