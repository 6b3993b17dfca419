#include "core/collision/response/friction.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "core/collision/model/feature_pairs.h"

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

bool in_pair_order(const Anchor& x, const Anchor& y) { return pair_order(x) < pair_order(y); }

// The anchors of edge pairs as (second edge, index of the anchor), in ascending order. Contains
// only anchors whose second edge is also the second edge of one of the contacts in `which`.
class BySecondEdge {
 public:
  BySecondEdge(const std::vector<Anchor>& anchors, const std::vector<Contact>& contacts,
               const std::vector<std::size_t>& which, Index n_edges) {
    std::vector<std::uint8_t> wanted;  // (edges) 1: second edge of a contact in `which`
    for (const std::size_t c : which)
      if (contacts[c].kind == ContactKind::EdgeEdge) {
        if (wanted.empty()) wanted.resize(n_edges, 0);
        wanted[contacts[c].b] = 1;
      }
    if (wanted.empty()) return;
    for (std::size_t i = 0; i < anchors.size(); ++i)
      if (anchors[i].kind == ContactKind::EdgeEdge && wanted[anchors[i].b])
        order_.push_back({anchors[i].b, static_cast<Index>(i)});
    std::sort(order_.begin(), order_.end());
  }

  // Calls use(index of the anchor) for the anchors with a given second edge.
  template <class Use>
  void each(Index edge, Use&& use) const {
    auto i = std::lower_bound(order_.begin(), order_.end(), std::pair<Index, Index>(edge, -1));
    for (; i != order_.end() && i->first == edge; ++i) use(i->second);
  }

 private:
  std::vector<std::pair<Index, Index>> order_;
};

// Returns, for each contact, the anchor of its feature pair, or null if there is none. `contacts`
// and `anchors` are sorted by (kind, a, b).
std::vector<const Anchor*> own_anchors(const std::vector<Contact>& contacts,
                                       const std::vector<Anchor>& anchors) {
  std::vector<const Anchor*> found(contacts.size(), nullptr);
  auto next = anchors.begin();
  for (std::size_t c = 0; c < contacts.size() && next != anchors.end(); ++c) {
    const std::uint64_t place = pair_order(contacts[c]);
    while (next != anchors.end() && pair_order(*next) < place) ++next;
    if (next != anchors.end() && pair_order(*next) == place) found[c] = &*next;
  }
  return found;
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
  std::vector<const Anchor*> found = own_anchors(contacts, anchors);
  std::vector<std::size_t> others;  // contacts whose pair has no anchor
  for (std::size_t c = 0; c < contacts.size(); ++c)
    if (!found[c]) others.push_back(c);
  const BySecondEdge turned(anchors, contacts, others, model.edges.rows());
  for (const std::size_t c : others) {
    const Contact& contact = contacts[c];
    // After all calls of consider(), found[c] is the anchor with the largest normal force among the
    // anchors of neighbouring pairs. If several have this force, it is the one that consider()
    // received first.
    const auto consider = [&](const Anchor& anchor, Index theirs, Index ours) {
      if (found[c] && anchor.normal_force <= found[c]->normal_force) return;
      if (neighbours(model, contact.kind, theirs, ours)) found[c] = &anchor;
    };
    const Anchor first{contact.kind, contact.a, 0, Vec3::Zero(), 0.0};
    auto from = std::lower_bound(anchors.begin(), anchors.end(), first, in_pair_order);
    for (; from != anchors.end() && from->kind == contact.kind && from->a == contact.a; ++from)
      consider(*from, from->b, contact.b);
    if (contact.kind == ContactKind::EdgeEdge)
      turned.each(contact.b, [&](Index i) { consider(anchors[i], anchors[i].a, contact.a); });
  }
  for (std::size_t c = 0; c < contacts.size(); ++c)
    if (const Anchor* const anchor = found[c])
      slips[c] = anchor->slip - contacts[c].normal * contacts[c].normal.dot(anchor->slip);
  return slips;
}

}  // namespace loomstone
