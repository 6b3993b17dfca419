// Displacements of a step, of which certification withholds a part: of cloth vertices one by one,
// of a free body as a whole. A vertex or body that a moving obstacle carries along follows the
// obstacle; only its motion relative to it is withheld:
//   x1 = x0 + carry + share (displacement - carry), and likewise for the pose of a body.
#pragma once

#include <vector>

#include "core/collision/certify/certify_report.h"
#include "core/collision/certify/impact_search.h"
#include "core/collision/model/free_body.h"
#include "core/collision/model/rigid_motion.h"

namespace loomstone {

class Displacements {
 public:
  // Vertices with an inverse mass are movable. withhold...() and carry...() change x1 and the ends
  // of bodies.
  Displacements(const CollisionModel& model, const Points& x0, const Vector& inverse_mass,
                Points& x1, FreeBodies& bodies);

  bool movable(Index v) const { return inverse_mass_[v] > 0.0; }
  // The unit of a vertex, which moves as a whole: itself, or its body, known by its first vertex.
  Index unit(Index v) const;
  double share(Index v) const { return share_[unit(v)]; }
  bool carried(Index v) const { return carrier_[unit(v)] != none; }

  // Makes `v` follow the immovable side of an impact.
  void carry_with_immovable(Index v, const StepImpact& impact);
  // Makes `v` follow the carrier of `other`.
  void carry_with_vertex(Index v, Index other);
  bool same_carrier(Index v, Index other) const;

  // Keeps `factor` of the unit's motion relative to its carrier.
  void withhold(Index unit, double factor);
  // Withholds all motion of a unit, including that of its carrier.
  void withhold_all(Index unit);

  // (n) 1: x1 has changed since the last call.
  std::vector<std::uint8_t> take_changed();

  // Adds the corrections of each body's end to its `moved` and `turned`.
  void finish();
  // Motion withheld from the requested displacements, ascending by vertex.
  std::vector<WithheldMotion> withheld() const;

 private:
  static constexpr Index none = -1,
                         local = -2;  // not carried; carried by a displacement of its own

  void set_carrier(Index v, Index carrier, const Vec3& motion);
  void apply(Index unit);

  const CollisionModel& model_;
  const Points& x0_;
  Points& x1_;
  const Vector& inverse_mass_;
  FreeBodies& bodies_;
  Points wanted_, carry_;  // (n x 3) requested displacement; carry, of a body that of its centre
  std::vector<double> share_;   // (n) of units
  std::vector<Index> carrier_;  // (n) of units: a surface, none or local
  std::vector<std::uint8_t> changed_;
  std::vector<RigidMotion> motions_;  // of surfaces
  std::vector<std::uint8_t> known_;
  std::vector<RigidPose> wanted_pose_, carried_pose_;  // of bodies
};

}  // namespace loomstone
