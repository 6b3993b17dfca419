#include "core/collision/certify/displacements.h"

#include <algorithm>
#include <cmath>

namespace loomstone {

Displacements::Displacements(const CollisionModel& model, const Points& x0,
                             const Vector& inverse_mass, Points& x1, FreeBodies& bodies)
    : model_(model),
      x0_(x0),
      x1_(x1),
      inverse_mass_(inverse_mass),
      bodies_(bodies),
      wanted_(x1 - x0),
      carry_(Points::Zero(x0.rows(), 3)),
      share_(x0.rows(), 1.0),
      carrier_(x0.rows(), none),
      changed_(x0.rows(), 0),
      motions_(model.surfaces.size()),
      known_(model.surfaces.size(), 0) {
  for (const FreeBody& body : bodies) {
    wanted_pose_.push_back(body.end);
    carried_pose_.push_back(body.start);
  }
}

Index Displacements::unit(Index v) const {
  const Index body = body_of_vertex(model_, bodies_, v);
  return body < 0 ? v : model_.surfaces[bodies_[body].surface].first_vertex;
}

void Displacements::carry_with_immovable(Index v, const StepImpact& impact) {
  if (carried(v)) return;
  double total = 0.0;
  Vec3 motion = Vec3::Zero();
  for (int i = 0; i < 4; ++i) {
    const Index u = impact.vertices[i];
    if (movable(u)) continue;
    const double weight = std::abs(impact.impact.weights[i]) + 1e-3;
    motion += weight * wanted_.row(u).transpose();
    total += weight;
    const Index s = model_.surface_of_vertex(u);
    if (model_.surfaces[s].kind == CollisionSurface::Kind::Cloth) continue;
    if (!known_[s]) {
      motions_[s] = rigid_motion(model_, s, x0_, x1_);
      known_[s] = 1;
    }
    if (motions_[s].rigid) {
      set_carrier(v, s, Vec3::Zero());
      return;
    }
  }
  set_carrier(v, local, motion / total);
}

void Displacements::carry_with_vertex(Index v, Index other) {
  set_carrier(v, carrier_[unit(other)], carry_.row(unit(other)));
}

bool Displacements::same_carrier(Index v, Index other) const {
  const Index a = unit(v), b = unit(other);
  return a == b ||
         (carrier_[a] == carrier_[b] && (carrier_[a] >= 0 || carry_.row(a) == carry_.row(b)));
}

void Displacements::withhold(Index unit, double factor) {
  share_[unit] *= factor;
  if (share_[unit] < 1e-3) share_[unit] = 0.0;
  apply(unit);
}

void Displacements::withhold_all(Index unit) {
  const Index body = body_of_vertex(model_, bodies_, unit);
  carrier_[unit] = none;
  carry_.row(unit).setZero();
  if (body >= 0) carried_pose_[body] = bodies_[body].start;
  share_[unit] = 0.0;
  apply(unit);
}

std::vector<std::uint8_t> Displacements::take_changed() {
  std::vector<std::uint8_t> changed(changed_.size(), 0);
  std::swap(changed, changed_);
  return changed;
}

void Displacements::set_carrier(Index v, Index carrier, const Vec3& motion) {
  if (carrier == local && motion.isZero(0.0)) return;
  if (carrier >= 0 && motions_[carrier].rotation.isIdentity(0.0) &&
      motions_[carrier].to == motions_[carrier].from)
    return;
  const Index u = unit(v), body = body_of_vertex(model_, bodies_, v);
  carrier_[u] = carrier;
  const Vec3 at = body < 0 ? Vec3(x0_.row(v).transpose()) : bodies_[body].start.position;
  const Vec3 carry = carrier >= 0 ? motions_[carrier].displacement(at) : motion;
  carry_.row(u) = carry.transpose();
  if (body >= 0) {
    RigidPose& pose = carried_pose_[body];
    pose = bodies_[body].start;
    pose.position += carry;
    if (carrier >= 0)
      pose.orientation =
          quaternion_product(quaternion_from_matrix(motions_[carrier].rotation), pose.orientation)
              .normalized();
  }
  apply(u);
}

void Displacements::apply(Index u) {
  const Index body = body_of_vertex(model_, bodies_, u);
  if (body < 0) {
    const Eigen::RowVector3d x =
        x0_.row(u) + carry_.row(u) + share_[u] * (wanted_.row(u) - carry_.row(u));
    if (x == x1_.row(u)) return;
    x1_.row(u) = x;
    changed_[u] = 1;
    return;
  }
  const RigidPose pose = between(carried_pose_[body], wanted_pose_[body], share_[u]);
  if (pose == bodies_[body].end) return;
  bodies_[body].end = pose;
  const CollisionSurface& surface = model_.surfaces[bodies_[body].surface];
  if (!place_body(model_, bodies_[body], pose, x1_)) return;
  for (Index i = 0; i < surface.n_vertices; ++i) changed_[surface.first_vertex + i] = 1;
}

void Displacements::finish() {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (bodies_[b].end == wanted_pose_[b]) continue;
    bodies_[b].moved += bodies_[b].end.position - wanted_pose_[b].position;
    bodies_[b].turned +=
        angular_velocity_between(wanted_pose_[b].orientation, bodies_[b].end.orientation, 1.0);
  }
}

std::vector<WithheldMotion> Displacements::withheld() const {
  std::vector<WithheldMotion> result;
  for (const CollisionSurface& surface : model_.surfaces) {
    if (surface.kind != CollisionSurface::Kind::Cloth) continue;
    for (Index v = surface.first_vertex; v < surface.first_vertex + surface.n_vertices; ++v) {
      const Vec3 withheld = (wanted_.row(v) - (x1_.row(v) - x0_.row(v))).transpose();
      if (movable(v) && !withheld.isZero(0.0))
        result.push_back({v, withheld, 1.0 / inverse_mass_[v]});
    }
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (bodies_[b].end == wanted_pose_[b]) continue;
    result.push_back({model_.surfaces[bodies_[b].surface].first_vertex,
                      wanted_pose_[b].position - bodies_[b].end.position,
                      1.0 / bodies_[b].inverse_mass});
  }
  std::sort(result.begin(), result.end(),
            [](const WithheldMotion& a, const WithheldMotion& b) { return a.vertex < b.vertex; });
  return result;
}

}  // namespace loomstone
