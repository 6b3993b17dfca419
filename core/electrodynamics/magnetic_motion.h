// Motion of rigid bodies that carry magnets and coils, or turn in bearings: kick-drift-kick
// (kick_drift_kick.h) with sub-steps short beside the fastest oscillation (substep_frequency.h).
// Circuits advance within the kicks (kick.h).
#pragma once

#include <optional>
#include <vector>

#include "core/electrodynamics/inductances.h"
#include "core/electrodynamics/kick.h"
#include "core/electrodynamics/magnetic_state.h"
#include "core/electrodynamics/magnets.h"
#include "core/electrodynamics/substep_frequency.h"

namespace loomstone {

// A step and what acts in it besides magnets.
struct MagneticStep {
  double start = 0.0, length = 0.0;                   // [s]
  const Points &impulses, &angular_impulses;          // (b x 3) that act first [N s], [N m s]
  const ObstaclePlaces &obstacles, &moved_obstacles;  // at its start, at its end
};

// The cost of a step, and its error.
struct MagneticEffort {
  int substeps = 0;
  double error = 0.0;  // largest estimated error of a force at the end [N]
};

// Stage. Keeps what acts at the instant at which the last step ended, where the next one begins:
// used again only for the same cause, to the last bit.
class MagneticMotion {
 public:
  explicit MagneticMotion(const MagneticModel& model);
  MagneticMotion(const MagneticMotion&) = delete;
  MagneticMotion& operator=(const MagneticMotion&) = delete;

  // Force [N] and torque about the centre [N m] on each body by magnets and coils with currents
  // (coils) [A].
  CarrierWrenches wrenches(const Team& team, const CarrierPlaces& places,
                           const Vector& currents) const;
  // Energy of all magnets in one another's field and in the uniform one, without what coils
  // magnetise [J]. moments: of induced dipoles, from which their search begins.
  double energy(const Team& team, const CarrierPlaces& places, const Points& moments) const;

  // Advances bodies, circuits and the moments of induced dipoles. `world` knows of no gravity and
  // no gyroscopic forces. Throws SolverFailure.
  MagneticEffort advance(const Team& team, const MagneticStep& step, RigidWorld& world,
                         RigidState& bodies, MagneticState& magnetic);

 private:
  // A place and time, and how obstacles move.
  struct Moment {
    CarrierPlaces places;
    const std::vector<Twist>& twists;
    double time;
  };
  // All that the actions at an instant depend on.
  struct Cause {
    Points positions;
    Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor> orientations;
    std::vector<RigidPose> obstacles;
    std::vector<std::uint8_t> resting;  // obstacles
    Vector given;                       // (coils) currents [A]
    bool operator==(const Cause& other) const = default;
  };
  struct Instant {
    Cause cause;
    Magnetised magnetised;
    Actions actions;
  };

  Cause cause_of(const Moment& moment) const;
  // Forces and inductances there, those of last_ if its cause is the same; moments: of induced
  // dipoles, where their search begins, and those found.
  const Instant& arrive(const Team& team, const Moment& moment, Points& moments);
  CircuitResponse response(const Team& team, const Moment& moment, const PlacedCoils& coils,
                           const Instant& idle) const;
  Vector probe_currents(const std::vector<MagneticBody>& magnets) const;
  double frequency(const Team& team, const CarrierPlaces& places, const Vector& currents,
                   const Instant& now, const RigidWorld& world) const;

  const MagneticModel& model_;
  Magnets magnets_;
  SubstepFrequency frequency_;
  MutualInductances inductances_;
  std::optional<Instant> last_;
};

}  // namespace loomstone
