// Displacements of a step that truncation shortens: of cloth vertices one by one, of a free body as
// a whole. What is carried by something that moves by script keeps that motion and loses only its
// own relative to it:
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
  // Vertices with an inverse mass can be moved; x1 and the bodies' ends are changed by shorten()
  // and carry...().
  Displacements(const CollisionModel& model, const Points& x0, const Vector& inverse_mass,
                Points& x1, FreeBodies& bodies);

  bool movable(Index v) const { return inverse_mass_[v] > 0.0; }
  // What is shortened with a vertex: itself, or its body, known by the body's first vertex.
  Index unit(Index v) const;
  double share(Index v) const { return share_[unit(v)]; }
  bool carried(Index v) const { return carrier_[unit(v)] != none; }

  // Makes `v` follow what cannot be moved in an impact.
  void carry_with_immovable(Index v, const StepImpact& impact);
  // Makes `v` follow what `other` follows.
  void carry_with_vertex(Index v, Index other);
  bool same_carrier(Index v, Index other) const;

  void shorten(Index unit, double factor);
  // Ends the step of a vertex or body where it began it, carried by nothing.
  void stay(Index unit);

  // (n) 1 where x1 has changed since the last call.
  std::vector<std::uint8_t> take_changed();

  // Adds to each body how truncation moved and turned its end.
  void finish();
  // Motion withheld from the wanted displacements, ascending.
  std::vector<WithheldMotion> withheld() const;

 private:
  static constexpr Index none = -1,
                         local = -2;  // carried by nothing; carried by a displacement of its own

  void set_carrier(Index v, Index carrier, const Vec3& motion);
  void apply(Index unit);

  const CollisionModel& model_;
  const Points& x0_;
  Points& x1_;
  const Vector& inverse_mass_;
  FreeBodies& bodies_;
  Points wanted_, carry_;       // (n x 3); of a body's unit the carry of its centre
  std::vector<double> share_;   // (n) of units
  std::vector<Index> carrier_;  // (n) of units: a surface, none or local
  std::vector<std::uint8_t> changed_;
  std::vector<RigidMotion> motions_;  // of surfaces
  std::vector<std::uint8_t> known_;
  std::vector<RigidPose> wanted_pose_, carried_pose_;  // of bodies
};

}  // namespace loomstone
