// Contact impulses: projected Gauss-Seidel on linearised gaps with Coulomb friction, between cloth
// vertices and free bodies (prescribed vertices and obstacles are infinitely heavy). Impulses are
// equal and opposite and act at one point in space, so they conserve linear and angular momentum of
// everything free. They act on positions at the end of the step: a displacement d is a change of
// velocity d / h.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "core/collision/model/feature_pairs.h"
#include "core/collision/model/free_body.h"

namespace loomstone {

// Requires a gap n . sum w x1 >= target at the end of the step. Weights and normal as in Contact;
// an edge that pierces a triangle has a fifth vertex.
struct ImpulseContact {
  ContactKind kind = ContactKind::VertexFace;
  PairKey key = 0;
  std::array<Index, 5> vertices{};
  std::array<double, 5> weights{};
  Vec3 normal = Vec3::Zero();
  double target = 0.0;          // [m]
  double largest_change = 0.0;  // of the gap by one impulse [m]
  bool cloth_only = true;       // both sides are cloth
  double scale = 0.0;           // displacement to which the tolerance is relative [m]
  double friction = 0.0;        // mu [1]

  // Accumulated so far.
  double pressed = 0.0;         // impulse times h along the normal [kg m]
  Vec3 dragged = Vec3::Zero();  // tangential impulse times h [kg m]

  void meet(const std::array<Index, 4>& four, const std::array<double, 4>& their_weights) {
    std::copy(four.begin(), four.end(), vertices.begin());
    std::copy(their_weights.begin(), their_weights.end(), weights.begin());
  }

  // Set by prepare().
  std::array<double, 5> factor{};       // w / m of the cloth vertices [1/kg]
  Index body = -1;                      // one side is cloth, so a contact has at most one free body
  double body_weight = 0.0;             // sum of its weights
  Vec3 arm = Vec3::Zero();              // from its centre to the point of the impulse [m]
  double normal_inverse_mass = 0.0;     // displacement of the gap by a unit impulse along n [1/kg]
  Mat3 tangential_mass = Mat3::Zero();  // impulse that cancels a tangential displacement [kg]
};

class Impulses {
 public:
  // `inverse_mass` (n): of cloth; 0 for prescribed vertices. hold_supported: supported bodies do
  // not move.
  Impulses(const CollisionModel& model, const Vector& inverse_mass, FreeBodies& bodies,
           bool hold_supported = false)
      : model_(model),
        inverse_mass_(inverse_mass),
        bodies_(bodies),
        hold_supported_(hold_supported) {}

  // `share`: time of contact as a fraction of the step. Returns false if nothing can move.
  bool prepare(ImpulseContact& contact, const Points& x0, const Points& x1, double share) const;

  // Corrects the ends of cloth (x1) and of bodies (end, moved, turned, and their rows of x1).
  // Sweeps until no impulse changes its gap by more than `tolerance` times its scale.
  void solve(std::vector<ImpulseContact>& contacts, const Points& x0, Points& x1, int most_sweeps,
             double tolerance);

 private:
  bool held(const FreeBody& body) const { return hold_supported_ && body.supported; }

  const CollisionModel& model_;
  const Vector& inverse_mass_;
  FreeBodies& bodies_;
  const bool hold_supported_;
};

}  // namespace loomstone
