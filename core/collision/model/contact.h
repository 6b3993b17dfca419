// Contacts and friction anchors. A contact is a pair of features closer than their thickness.
// Friction anchors persist from step to step.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/types.h"

namespace loomstone {

enum class ContactKind : std::uint8_t { VertexFace = 0, EdgeEdge = 1 };

struct Contact {
  ContactKind kind;
  Index a, b;                     // vertex id and triangle id, or two edge ids with a < b
  std::array<Index, 4> vertices;  // vertex and face corners, or ends of edge a and of edge b
  std::array<double, 4> weights;  // of the closest points: >= 0 in a (sum 1), <= 0 in b (sum -1)
  Vec3 normal;                    // unit normal from b to a
  double distance;                // distance at the start of the part of the step [m]
  double thickness;               // thickness xi of the pair, as returned by contact_distance() [m]
  double friction;                // friction coefficient mu of the pair [1]
};

// The friction anchors of all contacts, sorted by (kind, a, b).
struct ContactState {
  struct Anchor {
    ContactKind kind;
    Index a, b;
    Vec3 slip;  // tangential displacement of feature a relative to feature b, from the anchor [m]
    // Normal force times the contact's share (contact_shares()) [N], at the start of the part of
    // the step after which the anchor was stored.
    double normal_force;

    bool operator==(const Anchor& other) const = default;
  };
  std::vector<Anchor> anchors;
};

}  // namespace loomstone
