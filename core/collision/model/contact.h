// A near pair of features, as proximity finds it, and the friction anchors of such pairs.
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
  double thickness;               // xi = epsilon_c of the pair [m]
  double friction;                // mu of the pair [1]
};

// State: anchors of friction, sorted by (kind, a, b).
struct ContactState {
  struct Anchor {
    ContactKind kind;
    Index a, b;
    Vec3 slip;            // of a relative to b [m]
    double normal_force;  // of the last step [N]
  };
  std::vector<Anchor> anchors;
};

}  // namespace loomstone
