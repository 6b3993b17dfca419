// Motion of rigid bodies that carry magnets: kick-drift-kick with sub-steps short beside the
// fastest oscillation, world angular momentum as the variable. Contacts are answered by the
// rigid-body world at every sub-step; bodies that touch nothing move as if it were not there, so
// that their linear and angular momentum is kept to rounding and their paths are of second order.
//
// With F at the beginning and F' at the end of a sub-step h, the free body has v + h/2 a, then
// moves, then + h/2 a'. The world gets v + h a, so that what rests on something stays at rest; what
// touched goes on from its answer and adds h/2 (a' - a): the momentum is the same.
#pragma once

#include <optional>
#include <vector>

#include "core/magnetics/forces/interaction.h"
#include "core/magnetics/forces/stiffness.h"
#include "core/rigid/free_motion.h"
#include "core/electrodynamics/currents.h"
#include "core/sim/model/model.h"

namespace loomstone {

// Stage.
class MagneticMotion {
 public:
  explicit MagneticMotion(const Model& model);

  // All magnets at their poses; induced ones as the dipoles that they are there, with world axes;
  // coils magnetise them too.
  std::vector<MagneticBody> placed(const Team& team, const RigidState& state,
                                   const std::vector<RigidPose>& obstacles,
                                   const std::vector<MagneticBody>& coils) const;
  // Force [N] and torque about the centre [N m] on each body by magnets, of which coils with
  // currents (coils) [A] magnetise some; obstacles (o) stand at their poses.
  std::vector<Wrench> wrenches(const Team& team, const RigidState& state,
                               const std::vector<RigidPose>& obstacles,
                               const Vector& currents) const;
  // Of all magnets in one another's field and in the uniform one, without what coils magnetise [J].
  // moments: of induced dipoles, from which to begin.
  double energy(const Team& team, const RigidState& state, const std::vector<RigidPose>& obstacles,
                Points moments) const;

  struct Done {
    int substeps = 0;
    double error = 0.0;  // largest estimated error of a force at the end [N]
  };
  // Advances the bodies by `step`; impulses [N s] and angular impulses [N m s] (b x 3) act first;
  // obstacles go from one place to the other; `time` is that of the start [s]. `world` knows of no
  // gravity and no gyroscopic forces. moments: of induced dipoles, from which to begin, and those
  // at the end. Throws SolverFailure.
  Done advance(const Team& team, double step, const Points& impulses,
               const Points& angular_impulses, const ObstaclePlaces& obstacles,
               const ObstaclePlaces& moved_obstacles, double time, RigidWorld& world,
               RigidState& state, CircuitState& circuit, Points& moments);

 private:
  // Magnets and what they do to one another at one instant, without currents of circuits.
  struct Instant {
    std::vector<MagneticBody> magnets;
    std::vector<KnownField> known;
    std::vector<Wrench> forces;  // on each body and obstacle
  };
  // All that it depends on.
  struct Cause {
    Points positions;
    Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor> orientations;
    std::vector<RigidPose> obstacles;
    std::vector<std::uint8_t> resting;  // of obstacles
    Vector given;                       // (coils) currents [A]
    bool operator==(const Cause& other) const = default;
  };
  // Brings now_ to an instant and places the coils; a step begins where the one before has ended,
  // which is told by the cause.
  void arrive(const Team& team, const RigidState& state, const std::vector<RigidPose>& obstacles,
              double time, Points& moments);
  // known: what `placed` found out on the way, used again by wrenches. moments: of induced dipoles,
  // where to begin and what they are then.
  std::vector<MagneticBody> placed(const Team& team, const RigidState& state,
                                   const std::vector<RigidPose>& obstacles,
                                   const std::vector<MagneticBody>& coils,
                                   std::vector<KnownField>& known, Points* moments = nullptr) const;
  // On each body and obstacle.
  std::vector<Wrench> wrenches(const Team& team, const RigidState& state,
                               const std::vector<RigidPose>& obstacles,
                               const std::vector<MagneticBody>& magnets,
                               const std::vector<KnownField>& known) const;
  Vector amperes_beside(const std::vector<MagneticBody>& magnets) const;
  // Of the stiffest body, now_ [rad/s].
  double frequency(const Team& team, const RigidState& state,
                   const std::vector<RigidPose>& obstacles, const Vector& currents,
                   const RigidWorld& world) const;
  std::vector<MagneticBody> hard(const std::vector<MagneticBody>& magnets) const;
  void place_soft(const Team& team, std::vector<MagneticBody>& magnets,
                  const std::vector<MagneticBody>& coils) const;
  // Flux density at the induced spheres but for their own [T], and their places in the list of
  // magnets.
  Points applied_field(const Team& team, const std::vector<MagneticBody>& magnets,
                       const std::vector<MagneticBody>& coils,
                       std::vector<KnownField>& known) const;

  const Model& model_;
  std::vector<Rotor> rotors_;
  Currents currents_;
  std::vector<Index> groups_;  // carrier of each magnet, one number for all obstacles
  std::vector<CoarseMagnet> coarse_, coarse_coils_;  // coils: with one ampere
  std::vector<Index> hard_, induced_;                // places in the list of magnets
  Vector polarizabilities_;                          // of the induced ones, where they are dipoles
  bool soft_ = false;                                // the induced ones are not just dipoles
  std::optional<Cause> cause_;                       // of now_ and of the coils' places
  Instant now_;
};

}  // namespace loomstone
