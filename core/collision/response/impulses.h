// Contact impulses by projected Gauss-Seidel on linearised gaps, with Coulomb friction. Impulses
// act on cloth vertices and free bodies; prescribed vertices and obstacles have infinite mass.
// Impulses on the two features of a contact are equal and opposite, so they conserve linear
// momentum. Impulses between cloth and a body act at one point in space, so they also conserve
// angular momentum.
// Impulses correct positions at the end of the step. A correction d of a position corresponds to a
// velocity change d / h, where h is the step.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "core/collision/model/feature_pairs.h"
#include "core/collision/model/free_body.h"

namespace loomstone {

// Constraint on the gap at the end of the step: n . sum_i w_i x1_i >= target. Weights and normal
// are defined as in Contact. The fifth vertex is used only for an edge and the triangle that it
// pierces.
struct ImpulseContact {
  ContactKind kind = ContactKind::VertexFace;
  PairKey key = 0;
  std::array<Index, 5> vertices{};
  std::array<double, 5> weights{};
  Vec3 normal = Vec3::Zero();
  double target = 0.0;          // target gap [m]
  double largest_change = 0.0;  // largest gap change by one impulse [m]
  bool cloth_only = true;       // both features belong to cloth; used by CleanUp only
  double scale = 0.0;           // displacement to which the tolerance of solve() is relative [m]
  double friction = 0.0;        // friction coefficient mu [1]

  // Accumulated impulses.
  double pressed = 0.0;         // normal impulse times h [kg m]
  Vec3 dragged = Vec3::Zero();  // tangential impulse times h [kg m]

  void meet(const std::array<Index, 4>& four, const std::array<double, 4>& their_weights) {
    std::copy(four.begin(), four.end(), vertices.begin());
    std::copy(their_weights.begin(), their_weights.end(), weights.begin());
  }

  // The members from here on are set by prepare().
  std::array<double, 5> factor{};  // w / m of the cloth vertices [1/kg]
  // Index of the body that the impulse moves, or -1 if it moves none. If it moves a body, the other
  // feature belongs to cloth.
  Index body = -1;
  double body_weight = 0.0;          // sum of the weights of body vertices
  Vec3 arm = Vec3::Zero();           // from the body's centre of mass to the point of impulse [m]
  double normal_inverse_mass = 0.0;  // change of the gap per change of `pressed` [1/kg]
  // Maps a tangential displacement to the change of `dragged` that causes it [kg].
  Mat3 tangential_mass = Mat3::Zero();
};

class Impulses {
 public:
  // `inverse_mass` (n) [1/kg] is used for vertices that do not belong to `bodies`. It is 0 for
  // prescribed vertices and obstacles. If `hold_supported` is true, bodies with FreeBody::supported
  // do not move.
  Impulses(const CollisionModel& model, const Vector& inverse_mass, FreeBodies& bodies,
           bool hold_supported = false)
      : model_(model),
        inverse_mass_(inverse_mass),
        bodies_(bodies),
        hold_supported_(hold_supported) {}

  // Sets the members of `contact` that depend on the configuration. `share` is the time of contact
  // as a fraction of the step. Returns false if neither feature can move.
  bool prepare(ImpulseContact& contact, const Points& x0, const Points& x1, double share) const;

  // Corrects the end positions of cloth and bodies in x1. Updates the accumulated impulses of
  // contacts, and `end`, `moved` and `turned` of bodies. Stops after `most_sweeps` sweeps, or after
  // a sweep in which every change of an impulse, times `normal_inverse_mass`, is less than
  // `tolerance` times `scale` of its contact.
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
