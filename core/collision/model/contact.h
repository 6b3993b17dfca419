// Contacts: pairs of features closer than their thickness; and the friction anchors that contacts
// carry from step to step.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/types.h"

namespace loomstone {

enum class ContactKind : std::uint8_t { VertexFace = 0, EdgeEdge = 1 };

struct Contact {
  ContactKind kind;
  Index a, b;                     // vertex and triangle id, or two edge ids (a < b)
  std::array<Index, 4> vertices;  // vertex, face corners; or edge a, edge b
  std::array<double, 4> weights;  // signed: + on side a, - on side b; each side sums to 1
  Vec3 normal;                    // unit, from b to a
  double distance;                // at the start of the step [m]
  double thickness;               // of the pair, xi [m]
  double friction;                // coefficient of the pair, mu [1]
};

// State: friction anchors, sorted by (kind, a, b).
struct ContactState {
  struct Anchor {
    ContactKind kind;
    Index a, b;
    Vec3 slip;            // tangential displacement of a relative to b since the anchor was set [m]
    double normal_force;  // in the last step [N]
  };
  std::vector<Anchor> anchors;
};

}  // namespace loomstone
