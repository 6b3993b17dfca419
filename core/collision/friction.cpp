#include "core/collision/friction.h"

#include <algorithm>
#include <tuple>

namespace loomstone {

namespace {

using Anchor = ContactState::Anchor;

// Do the features of side b (or a) of an anchor and of a contact share a vertex?
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

bool by_a(const Anchor& x, const Anchor& y) { return std::tie(x.kind, x.a, x.b) < std::tie(y.kind, y.a, y.b); }

// Anchors of edges again, by their second edge.
std::vector<Anchor> sorted_by_b(const std::vector<Anchor>& anchors) {
  std::vector<Anchor> turned;
  for (const Anchor& anchor : anchors)
    if (anchor.kind == ContactKind::EdgeEdge) turned.push_back(anchor);
  std::sort(turned.begin(), turned.end(),
            [](const Anchor& x, const Anchor& y) { return std::tie(x.b, x.a) < std::tie(y.b, y.a); });
  return turned;
}

}  // namespace

FrictionResponse friction_response(const Vec3& slip, const Vec3& predicted, const Mat3& tangent, double stiffness, double limit) {
  const Vec3 trial = stiffness * (slip + predicted);
  const double size = trial.norm();
  if (size <= limit) return {stiffness * slip, stiffness * tangent};
  const double u = predicted.norm();
  const double secant = u * stiffness > limit ? limit / u : stiffness;
  return {limit / size * trial - secant * predicted, secant * tangent};
}

Vec3 slip_after(const Vec3& slip, const Vec3& actual, double stiffness, double limit) {
  const Vec3 trial = slip + actual;
  const double size = trial.norm(), largest = limit / stiffness;
  return size > largest ? Vec3(largest / size * trial) : trial;
}

std::vector<Vec3> anchored_slips(const std::vector<Contact>& contacts, const CollisionModel& model, const ContactState& state) {
  const std::vector<Anchor>& anchors = state.anchors;
  std::vector<Vec3> slips(contacts.size(), Vec3::Zero());
  if (anchors.empty()) return slips;
  const std::vector<Anchor> turned = sorted_by_b(anchors);
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const Contact& contact = contacts[c];
    const Anchor key{contact.kind, contact.a, contact.b, Vec3::Zero(), 0.0};
    const auto exact = std::lower_bound(anchors.begin(), anchors.end(), key, by_a);
    const Anchor* found = nullptr;
    if (exact != anchors.end() && !by_a(key, *exact)) {
      found = &*exact;
    } else {
      // The strongest neighbour; ties go to the first.
      auto from = std::lower_bound(anchors.begin(), anchors.end(), Anchor{contact.kind, contact.a, -1, Vec3::Zero(), 0.0}, by_a);
      for (; from != anchors.end() && from->kind == contact.kind && from->a == contact.a; ++from)
        if ((!found || from->normal_force > found->normal_force) && neighbours(model, contact.kind, from->b, contact.b))
          found = &*from;
      if (contact.kind == ContactKind::EdgeEdge) {
        auto other = std::lower_bound(turned.begin(), turned.end(), contact.b, [](const Anchor& x, Index b) { return x.b < b; });
        for (; other != turned.end() && other->b == contact.b; ++other)
          if ((!found || other->normal_force > found->normal_force) && neighbours(model, contact.kind, other->a, contact.a))
            found = &*other;
      }
    }
    if (found) slips[c] = found->slip - contact.normal * contact.normal.dot(found->slip);
  }
  return slips;
}

}  // namespace loomstone
