#include "core/collision/response/friction.h"

#include <algorithm>
#include <tuple>

namespace loomstone {

namespace {

using Anchor = ContactState::Anchor;

// Returns whether two triangles, or two edges, have a common vertex.
bool neighbours(const CollisionModel& model, ContactKind kind, Index first, Index second) {
  const int n = kind == ContactKind::VertexFace ? 3 : 2;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const Index u = n == 3 ? model.triangles(first, i) : model.edges(first, i);
      const Index v = n == 3 ? model.triangles(second, j) : model.edges(second, j);
      if (u == v) return true;
    }
  return false;
}

bool by_a(const Anchor& x, const Anchor& y) {
  return std::tie(x.kind, x.a, x.b) < std::tie(y.kind, y.a, y.b);
}

// Returns the anchors of edge pairs as (second edge, index of the anchor), in ascending order.
std::vector<std::pair<Index, Index>> by_second_edge(const std::vector<Anchor>& anchors) {
  std::vector<std::pair<Index, Index>> order;
  for (std::size_t i = 0; i < anchors.size(); ++i)
    if (anchors[i].kind == ContactKind::EdgeEdge)
      order.push_back({anchors[i].b, static_cast<Index>(i)});
  std::sort(order.begin(), order.end());
  return order;
}

}  // namespace

FrictionResponse friction_response(const Vec3& slip, const Vec3& predicted, const Mat3& tangent,
                                   double stiffness, double limit) {
  if (!(limit > 0.0)) return {Vec3::Zero(), Mat3::Zero()};
  const Vec3 trial = stiffness * (slip + predicted);
  const double size = trial.norm();
  if (size <= limit) return {stiffness * slip, stiffness * tangent};
  const double u = predicted.norm();
  const double secant = u * stiffness > limit ? limit / u : stiffness;
  return {limit / size * trial - secant * predicted, secant * tangent};
}

Vec3 sped_up(const Vec3& slip, const Vec3& predicted, const Vec3& gained, double stiffness,
             double limit) {
  const double size2 = predicted.squaredNorm();
  if (!(size2 > 0.0) || !(slip.dot(predicted) > 0.0)) return predicted;
  if (stiffness * (slip + predicted).norm() <= limit) return predicted;  // the contact sticks
  return (1.0 + std::clamp(gained.dot(predicted) / size2, 0.0, 1.0)) * predicted;
}

FrictionState friction_at(const Vec3& slip, const Vec3& moved, const Mat3& tangent,
                          double stiffness, double limit, bool secant) {
  if (!(limit > 0.0)) return {Vec3::Zero(), Mat3::Zero(), 0.0};
  const Vec3 stretch = slip + moved;
  const double length = stretch.norm();
  if (stiffness * length <= limit)
    return {stiffness * stretch, stiffness * tangent, 0.5 * stiffness * length * length};
  const Vec3 along = stretch / length;
  const Mat3 turning = secant ? tangent : Mat3(tangent - along * along.transpose());
  return {limit * along, limit / length * turning, limit * (length - 0.5 * limit / stiffness)};
}

Vec3 slip_after(const Vec3& slip, const Vec3& actual, double stiffness, double limit) {
  const Vec3 trial = slip + actual;
  const double size = trial.norm(), largest = limit / stiffness;
  return size > largest ? Vec3(largest / size * trial) : trial;
}

std::vector<Vec3> anchored_slips(const std::vector<Contact>& contacts, const CollisionModel& model,
                                 const ContactState& state) {
  const std::vector<Anchor>& anchors = state.anchors;
  std::vector<Vec3> slips(contacts.size(), Vec3::Zero());
  if (anchors.empty()) return slips;
  std::vector<std::pair<Index, Index>> turned;  // built when first needed
  auto exact = anchors.begin();  // both lists are sorted, so one pass finds equal pairs
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const Contact& contact = contacts[c];
    const Anchor key{contact.kind, contact.a, contact.b, Vec3::Zero(), 0.0};
    while (exact != anchors.end() && by_a(*exact, key)) ++exact;
    const Anchor* found = nullptr;
    if (exact != anchors.end() && !by_a(key, *exact)) {
      found = &*exact;
    } else {
      // Selects the neighbour with the largest normal force, or the first of several such
      // neighbours.
      const auto consider = [&](const Anchor& anchor, Index theirs, Index ours) {
        if (found && anchor.normal_force <= found->normal_force) return;
        if (neighbours(model, contact.kind, theirs, ours)) found = &anchor;
      };
      const Anchor first{contact.kind, contact.a, -1, Vec3::Zero(), 0.0};
      auto from = std::lower_bound(anchors.begin(), anchors.end(), first, by_a);
      for (; from != anchors.end() && from->kind == contact.kind && from->a == contact.a; ++from)
        consider(*from, from->b, contact.b);
      if (contact.kind == ContactKind::EdgeEdge) {
        if (turned.empty()) turned = by_second_edge(anchors);
        auto other =
            std::lower_bound(turned.begin(), turned.end(), std::pair<Index, Index>(contact.b, -1));
        for (; other != turned.end() && other->first == contact.b; ++other)
          consider(anchors[other->second], anchors[other->second].a, contact.a);
      }
    }
    if (found) slips[c] = found->slip - contact.normal * contact.normal.dot(found->slip);
  }
  return slips;
}

}  // namespace loomstone
