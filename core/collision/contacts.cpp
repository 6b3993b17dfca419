#include "core/collision/contacts.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "core/collision/distance.h"

namespace loomstone {

namespace {

// Distances below this are treated as this one, so that forces stay finite at a start that touches [m].
constexpr double least_distance = 1e-9;
// Edges carry their full share where the closest points are farther than this part of the edge from its ends, and the
// squared sine of their angle is above the other. Our choice.
constexpr double end_fade = 0.1, parallel_fade = 0.04;

double smooth_step(double x) {
  x = std::clamp(x, 0.0, 1.0);
  return x * x * (3.0 - 2.0 * x);
}

bool before(const Contact& a, const Contact& b) {
  return std::tie(a.kind, a.a, a.b) < std::tie(b.kind, b.a, b.b);
}

double edge_share(const Contact& contact, const Points& x0) {
  const auto edge = [&](int i) { return Vec3((x0.row(contact.vertices[i + 1]) - x0.row(contact.vertices[i])).transpose()); };
  const Vec3 a = edge(0), b = edge(2);
  const double lengths2 = a.squaredNorm() * b.squaredNorm();
  if (!(lengths2 > 0.0)) return 0.0;
  double share = smooth_step(a.cross(b).squaredNorm() / lengths2 / parallel_fade);
  for (const double weight : contact.weights) share *= smooth_step(std::abs(weight) / end_fade);
  return share;
}

}  // namespace

ContactForce contact_force(double distance, double thickness, double stiffness) {
  const double half = 0.5 * thickness;
  if (distance >= thickness) return {0.0, 0.0, 0.0};
  if (distance > half) {
    const double depth = thickness - distance;
    return {stiffness * depth, stiffness, 0.5 * stiffness * depth * depth};
  }
  const double d = std::max(distance, least_distance);
  return {stiffness * half * half / d, stiffness * half * half / (d * d),
          0.5 * stiffness * half * half + stiffness * half * half * std::log(half / d)};
}

std::vector<Contact> find_contacts(const Team& team, const CollisionModel& model, const std::vector<SurfacePair>& pairs,
                                   const Points& x, NearLists& lists) {
  constexpr Index grain = 512;
  std::vector<Contact> contacts;
  const auto scan = [&](Index i, ContactKind kind, const std::vector<PairKey>& keys, std::vector<double>& distances) {
    const Index n = static_cast<Index>(keys.size());
    std::vector<std::vector<Contact>> of_range((n + grain - 1) / grain);
    parallel_ranges(team, n, grain, [&](Index begin, Index end) {
      for (Index e = begin; e < end; ++e) {
        const std::array<Index, 4> v = pair_vertices(model, kind, keys[e]);
        FourPoints p;
        for (int k = 0; k < 4; ++k) p[k] = x.row(v[k]).transpose();
        const bool face = kind == ContactKind::VertexFace;
        const ClosestPair closest = face ? closest_vertex_face(p) : closest_edge_edge(p);
        distances[e] = closest.distance;
        if (!(closest.distance < pairs[i].thickness) || (!face && !closest.interior)) continue;
        const Vec3 normal = face ? contact_normal_vertex_face(p, closest, Vec3::Zero())
                                 : contact_normal_edge_edge(p, closest, Vec3::Zero());
        of_range[begin / grain].push_back({kind, first_of(keys[e]), second_of(keys[e]), v, closest.weights, normal,
                                           closest.distance, pairs[i].thickness, pairs[i].friction});
      }
    });
    for (const std::vector<Contact>& range : of_range) contacts.insert(contacts.end(), range.begin(), range.end());
  };
  for (Index i = 0; i < static_cast<Index>(pairs.size()); ++i) {
    NearList& list = lists.list(i);
    scan(i, ContactKind::VertexFace, list.pairs.vertex_face, list.vertex_face_distance);
    scan(i, ContactKind::EdgeEdge, list.pairs.edge_edge, list.edge_edge_distance);
  }
  if (!std::is_sorted(contacts.begin(), contacts.end(), before)) std::sort(contacts.begin(), contacts.end(), before);
  return contacts;
}

std::vector<double> contact_shares(const std::vector<Contact>& contacts, const CollisionModel& model, const Points& x0) {
  const std::size_t n = contacts.size();
  std::vector<double> shares(n, 1.0);
  for (std::size_t begin = 0; begin < n;) {
    if (contacts[begin].kind == ContactKind::EdgeEdge) {
      shares[begin] = edge_share(contacts[begin], x0);
      ++begin;
      continue;
    }
    std::size_t end = begin + 1;
    while (end < n && contacts[end].kind == ContactKind::VertexFace && contacts[end].a == contacts[begin].a) ++end;
    for (std::size_t i = begin; i < end; ++i) {
      const Contact& own = contacts[i];
      const double own_force = contact_force(own.distance, own.thickness, 1.0).force;
      double count = 1.0;
      for (std::size_t j = begin; j < end; ++j) {
        const Contact& other = contacts[j];
        if (i == j || model.surface_of_triangle[own.b] != model.surface_of_triangle[other.b]) continue;
        const double alike = std::max(0.0, own.normal.dot(other.normal));
        const double other_force = contact_force(other.distance, other.thickness, 1.0).force;
        count += alike * alike * std::min(1.0, other_force / own_force);
      }
      shares[i] = 1.0 / count;
    }
    begin = end;
  }
  return shares;
}

}  // namespace loomstone
