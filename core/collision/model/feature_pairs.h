// Pairs of surfaces that may collide, and pairs of their features. A feature pair consists of a
// vertex and a triangle, or of two edges.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/collision/model/collision_model.h"
#include "core/collision/model/contact.h"

namespace loomstone {

// A pair of surfaces. The first one is cloth. a == b denotes self-collision of a cloth.
struct SurfacePair {
  Index a, b;
  double thickness;  // mean thickness xi [m]
  double friction;   // geometric mean mu of the friction coefficients [1]
};

std::vector<SurfacePair> surface_pairs(const CollisionModel& model);

// A feature pair packed as a << 32 | b, where a and b are the ids of a vertex and a triangle, or of
// two edges (a < b).
using PairKey = std::uint64_t;
inline PairKey pair_key(Index a, Index b) {
  return static_cast<PairKey>(static_cast<std::uint32_t>(a)) << 32 | static_cast<std::uint32_t>(b);
}
inline Index first_of(PairKey key) { return static_cast<Index>(key >> 32); }
inline Index second_of(PairKey key) { return static_cast<Index>(key & 0xffffffffu); }

// Returns a sort key below 2^63 that orders feature pairs by (kind, a, b).
inline std::uint64_t pair_order(ContactKind kind, PairKey key) {
  return static_cast<std::uint64_t>(kind) << 62 | (key >> 32) << 31 | (key & 0x7fffffffu);
}

// Returns the sort key of a feature pair of any type with members kind, a and b, such as Contact.
template <class Pair>
std::uint64_t pair_order(const Pair& pair) {
  return pair_order(pair.kind, pair_key(pair.a, pair.b));
}

// pair_order() as a function object.
inline constexpr auto place_of_pair = [](const auto& pair) { return pair_order(pair); };

struct FeaturePairs {  // in results of BroadPhase, both lists are in ascending order
  std::vector<PairKey> vertex_face, edge_edge;
};

// Returns the vertex and the corners of the face, or the ends of edge a and then those of edge b.
inline std::array<Index, 4> pair_vertices(const CollisionModel& model, ContactKind kind,
                                          PairKey key) {
  const Index a = first_of(key), b = second_of(key);
  if (kind == ContactKind::VertexFace)
    return {a, model.triangles(b, 0), model.triangles(b, 1), model.triangles(b, 2)};
  return {model.edges(a, 0), model.edges(a, 1), model.edges(b, 0), model.edges(b, 1)};
}

// Returns the smallest AttachedTo::distance [m] of the vertices that are attached to the surface of
// the other feature, or infinity if there is no such vertex.
double attached_distance(const CollisionModel& model, ContactKind kind,
                         const std::array<Index, 4>& vertices);

// Returns the distance at which two features of a surface pair come into contact [m]: the thickness
// of the pair or attached_distance(), whichever is smaller. It is 0 if an attachment excludes
// contacts between the features.
double contact_distance(const CollisionModel& model, const SurfacePair& pair, ContactKind kind,
                        const std::array<Index, 4>& vertices);

}  // namespace loomstone
