#include "core/collision/clean_up.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace loomstone {

namespace {

constexpr double target_gap = 0.2;  // [thickness], as measured in the notes
constexpr int n_sweeps = 12;

}  // namespace

void CleanUp::solve(const std::vector<StepImpact>& impacts, const Points& x0, const Vector& inverse_mass, Points& x1) {
  const auto before = [](const Constraint& a, const Constraint& b) {
    return std::tie(a.kind, a.key) < std::tie(b.kind, b.key);
  };
  std::vector<Constraint> added;
  for (const StepImpact& each : impacts) {
    Constraint c;
    c.kind = each.kind;
    c.key = each.key;
    c.vertices = each.vertices;
    c.weights = each.impact.weights;
    c.normal = each.impact.normal;
    c.inverse_mass = 0.0;
    Vec3 travel = Vec3::Zero();
    for (int i = 0; i < 4; ++i) {
      c.inverse_mass += c.weights[i] * c.weights[i] * inverse_mass[c.vertices[i]];
      travel += c.weights[i] * (x1.row(c.vertices[i]) - x0.row(c.vertices[i])).transpose();
    }
    if (!(c.inverse_mass > 0.0)) continue;
    const SurfacePair& pair = pairs_[each.pair];
    c.target = std::min(target_gap * pair.thickness, std::max(each.impact.start_distance, 2.0 * largest_gap_floor));
    c.largest_change = travel.norm() + pair.thickness;
    c.friction = pair.friction;
    added.push_back(c);
  }
  // A pair that was hit again is linearised anew; what it has pressed stays pressed.
  std::vector<Constraint> merged;
  std::size_t i = 0, j = 0;
  while (i < constraints_.size() || j < added.size()) {
    if (j == added.size() || (i < constraints_.size() && before(constraints_[i], added[j]))) {
      merged.push_back(constraints_[i++]);
    } else {
      if (i < constraints_.size() && !before(added[j], constraints_[i])) ++i;
      merged.push_back(added[j++]);
    }
  }
  constraints_ = std::move(merged);

  for (int sweep = 0; sweep < n_sweeps; ++sweep) {
    double largest = 0.0;
    for (Constraint& c : constraints_) {
      Vec3 end = Vec3::Zero(), start = Vec3::Zero();
      for (int k = 0; k < 4; ++k) {
        end += c.weights[k] * x1.row(c.vertices[k]).transpose();
        start += c.weights[k] * x0.row(c.vertices[k]).transpose();
      }
      const double lack = std::clamp(c.target - c.normal.dot(end), -c.largest_change, c.largest_change);
      const double pressed = std::max(0.0, c.pressed + lack / c.inverse_mass);
      Vec3 impulse = (pressed - c.pressed) * c.normal;
      c.pressed = pressed;

      // Coulomb: the tangential impulse that stops the relative motion, no larger than mu times the normal one.
      const Vec3 moved = end - start, across = moved - c.normal * c.normal.dot(moved);
      Vec3 dragged = c.dragged - across / c.inverse_mass;
      const double size = dragged.norm(), limit = c.friction * c.pressed;
      if (size > limit) dragged *= limit / size;
      impulse += dragged - c.dragged;
      c.dragged = dragged;

      for (int k = 0; k < 4; ++k) {
        const double factor = c.weights[k] * inverse_mass[c.vertices[k]];
        if (factor != 0.0) x1.row(c.vertices[k]) += factor * impulse.transpose();
      }
      largest = std::max(largest, impulse.norm() * c.inverse_mass / c.target);
    }
    if (largest < 1e-3) break;
  }
}

}  // namespace loomstone
