#include "core/collision/response/impulses.h"

#include <algorithm>
#include <cmath>

namespace loomstone {

namespace {

Mat3 cross_matrix(const Vec3& v) {
  Mat3 m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// Restricts the positive definite matrix k to the plane perpendicular to n and returns the inverse
// of the restriction. The returned matrix maps n to zero.
Mat3 tangential_inverse(const Mat3& k, const Vec3& n) {
  const Vec3 a = n.unitOrthogonal(), b = n.cross(a);
  const double aa = a.dot(k * a), ab = a.dot(k * b), bb = b.dot(k * b),
               determinant = aa * bb - ab * ab;
  return (bb * a * a.transpose() - ab * (a * b.transpose() + b * a.transpose()) +
          aa * b * b.transpose()) /
         determinant;
}

}  // namespace

bool Impulses::prepare(ImpulseContact& c, const Points& x0, const Points& x1, double share) const {
  double cloth = 0.0;  // sum of w^2 / m [1/kg]
  Vec3 point = Vec3::Zero();
  c.body = -1;
  c.body_weight = 0.0;
  c.factor.fill(0.0);
  for (int i = 0; i < 5; ++i) {
    if (c.weights[i] == 0.0) continue;
    const Index v = c.vertices[i], body = body_of_vertex(model_, bodies_, v);
    if (body >= 0) {
      c.body = body;
      c.body_weight += c.weights[i];
      continue;
    }
    c.factor[i] = c.weights[i] * inverse_mass_[v];
    cloth += c.weights[i] * c.factor[i];
    // The impulse acts at the contact point of the cloth. In a contact with a body, the magnitudes
    // of the weights of cloth sum to 1.
    point += std::abs(c.weights[i]) * (x0.row(v) + share * (x1.row(v) - x0.row(v))).transpose();
  }
  if (c.body < 0 || held(bodies_[c.body])) {
    c.body = -1;
    if (!(cloth > 0.0)) return false;
    c.normal_inverse_mass = cloth;
    c.tangential_mass = (Mat3::Identity() - c.normal * c.normal.transpose()) / cloth;
    return true;
  }
  const FreeBody& body = bodies_[c.body];
  c.arm = point - between(body.start, body.end, share).position;
  const Mat3 s = cross_matrix(c.arm);
  const Mat3 k = (cloth + c.body_weight * c.body_weight * body.inverse_mass) * Mat3::Identity() -
                 c.body_weight * c.body_weight * s * body.inverse_inertia * s;
  c.normal_inverse_mass = c.normal.dot(k * c.normal);
  if (!(c.normal_inverse_mass > 0.0)) return false;
  c.tangential_mass = tangential_inverse(k, c.normal);
  return true;
}

void Impulses::solve(std::vector<ImpulseContact>& contacts, const Points& x0, Points& x1,
                     int most_sweeps, double tolerance) {
  struct Change {
    Vec3 moved = Vec3::Zero(), turned = Vec3::Zero();
  };
  std::vector<Change> changes(bodies_.size());
  for (int sweep = 0; sweep < most_sweeps; ++sweep) {
    double largest = 0.0;
    for (ImpulseContact& c : contacts) {
      Vec3 end = Vec3::Zero(), start = Vec3::Zero();
      for (int k = 0; k < 5; ++k) {
        end += c.weights[k] * x1.row(c.vertices[k]).transpose();
        start += c.weights[k] * x0.row(c.vertices[k]).transpose();
      }
      if (c.body >= 0)
        end += c.body_weight * (changes[c.body].moved + changes[c.body].turned.cross(c.arm));
      const double lack =
          std::clamp(c.target - c.normal.dot(end), -c.largest_change, c.largest_change);
      const double pressed = std::max(0.0, c.pressed + lack / c.normal_inverse_mass);
      Vec3 impulse = (pressed - c.pressed) * c.normal;
      c.pressed = pressed;

      // Coulomb friction: the tangential impulse is the one that stops the relative motion, limited
      // to mu times the normal impulse.
      const Vec3 moved = end - start;
      Vec3 dragged = c.dragged - c.tangential_mass * moved;
      const double size = dragged.norm(), limit = c.friction * c.pressed;
      if (size > limit) dragged *= limit / size;
      impulse += dragged - c.dragged;
      c.dragged = dragged;

      for (int k = 0; k < 5; ++k)
        if (c.factor[k] != 0.0) x1.row(c.vertices[k]) += c.factor[k] * impulse.transpose();
      if (c.body >= 0) {
        const FreeBody& body = bodies_[c.body];
        changes[c.body].moved += c.body_weight * body.inverse_mass * impulse;
        changes[c.body].turned += body.inverse_inertia * (c.body_weight * c.arm.cross(impulse));
      }
      largest = std::max(largest, impulse.norm() * c.normal_inverse_mass / c.scale);
    }
    if (largest < tolerance) break;
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (changes[b].moved.isZero(0.0) && changes[b].turned.isZero(0.0)) continue;
    FreeBody& body = bodies_[b];
    body.end.position += changes[b].moved;
    body.end.orientation = turned(body.end.orientation, changes[b].turned, 1.0);
    body.moved += changes[b].moved;
    body.turned += changes[b].turned;
    place_body(model_, body, body.end, x1);
  }
}

}  // namespace loomstone
