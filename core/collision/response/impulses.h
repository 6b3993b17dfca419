// Impulses at contacts: projected Gauss-Seidel on linearised gaps with Coulomb friction, between
// cloth vertices and free bodies of given mass (scripts and pins are infinitely heavy). Impulses
// are equal and opposite and act on one point of space, so linear and angular momentum of what is
// free stay what they are. Positions stand for velocities: a displacement d of the end of a step is
// a change of velocity d / h.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "core/collision/model/feature_pairs.h"
#include "core/collision/model/free_body.h"

namespace loomstone {

// Asks for a gap n . sum w x1 >= target at the end of the step. Weights and normal as in Contact; a
// fifth vertex where an edge meets a triangle.
struct ImpulseContact {
  ContactKind kind = ContactKind::VertexFace;
  PairKey key = 0;
  std::array<Index, 5> vertices{};
  std::array<double, 5> weights{};
  Vec3 normal = Vec3::Zero();
  double target = 0.0;          // [m]
  double largest_change = 0.0;  // of the gap by one impulse [m]
  bool cloth_only = true;       // both sides are cloth
  double scale = 0.0;           // of displacements that count [m]
  double friction = 0.0;        // mu [1]

  // What it has done so far.
  double pressed = 0.0;         // impulse times h along the normal [kg m]
  Vec3 dragged = Vec3::Zero();  // across it [kg m]

  void meet(const std::array<Index, 4>& four, const std::array<double, 4>& their_weights) {
    std::copy(four.begin(), four.end(), vertices.begin());
    std::copy(their_weights.begin(), their_weights.end(), weights.begin());
  }

  // Set by prepare().
  std::array<double, 5> factor{};    // w / m of the cloth vertices [1/kg]
  Index body = -1;                   // a contact is of cloth with something: at most one free body
  double body_weight = 0.0;          // sum of its weights
  Vec3 arm = Vec3::Zero();           // where the impulse acts, from its centre [m]
  double normal_inverse_mass = 0.0;  // displacement of the gap by a unit impulse along n [1/kg]
  Mat3 tangential_mass = Mat3::Zero();  // impulse that undoes a displacement across n [kg]
};

class Impulses {
 public:
  // `inverse_mass` (n): of cloth; 0 for what is held. hold_supported: bodies that press on what
  // does not give way stay.
  Impulses(const CollisionModel& model, const Vector& inverse_mass, FreeBodies& bodies,
           bool hold_supported = false)
      : model_(model),
        inverse_mass_(inverse_mass),
        bodies_(bodies),
        hold_supported_(hold_supported) {}

  // `x`: positions of the vertices when they touch, `share` that time as a part of the step. False
  // where nothing can move.
  bool prepare(ImpulseContact& contact, const Points& x0, const Points& x1, double share) const;

  // Moves ends of cloth (x1) and bodies (end, moved, turned, and their rows of x1). Sweeps until no
  // impulse changes its gap by more than `tolerance` times its scale.
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
