// Displacements of a step, from which certification withholds motion. A unit is a single cloth
// vertex or a whole free body. A unit can be carried by a surface or by vertices that certification
// cannot move, such as a moving obstacle or prescribed vertices. The unit then follows this
// carrier, and withhold() affects only the motion of the unit relative to the carrier:
//   x1 = x0 + carry + share (displacement - carry)
// `displacement` is the requested displacement of the unit, `carry` the displacement that the
// carrier gives the unit (0 without a carrier), and `share` the fraction of the relative motion
// that the unit keeps. The pose of a body is interpolated in the same way.
#pragma once

#include <vector>

#include "core/collision/certify/certify_report.h"
#include "core/collision/certify/impact_search.h"
#include "core/collision/model/free_body.h"
#include "core/collision/model/rigid_motion.h"

namespace loomstone {

class Displacements {
 public:
  // Vertices with a positive inverse mass are movable. The functions withhold...() and carry...()
  // change x1 and the end poses of bodies.
  Displacements(const CollisionModel& model, const Points& x0, const Vector& inverse_mass,
                Points& x1, FreeBodies& bodies);

  bool movable(Index v) const { return inverse_mass_[v] > 0.0; }
  // Returns the unit of a vertex: the vertex itself, or the first vertex of its body.
  Index unit(Index v) const;
  double share(Index v) const { return share_[unit(v)]; }
  bool carried(Index v) const { return carrier_[unit(v)] != none; }

  // Makes the unit of `v` follow the immovable vertices of an impact. If one of them belongs to a
  // body or obstacle that moves rigidly, the unit follows the motion of this body or obstacle,
  // otherwise the weighted mean displacement of these vertices. Does nothing if the unit already
  // has a carrier, or if this motion is zero.
  void carry_with_immovable(Index v, const StepImpact& impact);
  // Makes the unit of `v` follow the carrier of the unit of `other`.
  void carry_with_vertex(Index v, Index other);
  bool same_carrier(Index v, Index other) const;

  // Multiplies the unit's motion relative to its carrier by `factor`. If less than 0.1 % of the
  // requested relative motion is left, withholds all of it.
  void withhold(Index unit, double factor);
  // Withholds all motion of a unit, including the motion that its carrier gives it.
  void withhold_all(Index unit);

  // Returns a flag for each vertex (n) and resets the flags. 1: x1 of the vertex, or of another
  // vertex of its body, has changed since the last call.
  std::vector<std::uint8_t> take_changed();

  // Adds the correction of each body's end pose to FreeBody::moved and FreeBody::turned.
  void finish();
  // Returns the withheld part of the requested displacements, sorted by vertex.
  std::vector<WithheldMotion> withheld() const;

 private:
  // Special values of carrier_. none: the unit has no carrier. local: the unit follows the weighted
  // mean displacement of the immovable vertices of an impact instead of a rigidly moving surface.
  static constexpr Index none = -1, local = -2;

  void set_carrier(Index v, Index carrier, const Vec3& motion);
  void apply(Index unit);

  const CollisionModel& model_;
  const Points& x0_;
  Points& x1_;
  const Vector& inverse_mass_;
  FreeBodies& bodies_;
  // (n x 3) wanted_ contains the requested displacement of each vertex [m]. carry_ contains the
  // displacement that the carrier gives each unit [m]; for a body, that of the body's centre.
  Points wanted_, carry_;
  // (n) Fraction that a unit keeps of its motion relative to its carrier.
  std::vector<double> share_;
  std::vector<Index> carrier_;  // (n) carrier of each unit: index of a surface, `none` or `local`
  std::vector<std::uint8_t> changed_;
  std::vector<RigidMotion> motions_;  // motion of each surface; set if known_ is 1
  std::vector<std::uint8_t> known_;
  // (bodies) End pose of a body that keeps all, or none, of its motion relative to its carrier.
  std::vector<RigidPose> wanted_pose_, carried_pose_;
};

}  // namespace loomstone
