// Motion of the rigid bodies in a scene with magnets, coils or bearings. The integrator is
// kick-drift-kick (kick_drift_kick.h) with sub-steps that resolve the fastest oscillation and the
// relative motion of magnets and coils (substep_frequency.h), and that bound the error of the work
// (work_error.h). Circuits advance within the kicks (kick.h).
#pragma once

#include <optional>
#include <vector>

#include "core/electrodynamics/inductances.h"
#include "core/electrodynamics/kick.h"
#include "core/electrodynamics/magnetic_state.h"
#include "core/electrodynamics/magnets.h"
#include "core/electrodynamics/substep_frequency.h"

namespace loomstone {

// Input of a step: its start time and length, external impulses on the bodies at its start and end,
// and the motion of the obstacles.
struct MagneticStep {
  double start = 0.0, length = 0.0;  // [s]
  const BodyImpulses &at_start, &at_end;
  const ObstaclePlaces &obstacles, &moved_obstacles;  // at the start and at the end
};

// Cost and error of a step, and the work of obstacles in it.
struct MagneticEffort {
  int substeps = 0;
  // Largest estimated error of the magnets' force on a body at the end of the step [N].
  double error = 0.0;
  // Work that scripted obstacles do on bodies through contacts and magnets [J]. Work that they do
  // through coils is part of the energy supplied to the circuits.
  double obstacle_work = 0.0;
};

// The motion of bodies under magnetic forces. The actions at the end of a step are cached, because
// the next step begins there. They are reused only if all their inputs are exactly the same.
class MagneticMotion {
 public:
  explicit MagneticMotion(const MagneticModel& model);
  MagneticMotion(const MagneticMotion&) = delete;
  MagneticMotion& operator=(const MagneticMotion&) = delete;

  // Returns the forces [N] and the torques about the centres of mass [N m] on the bodies. They are
  // due to the magnets, to the coils with `currents` (coils) [A], and to the uniform field.
  CarrierWrenches wrenches(const Team& team, const CarrierPlaces& places,
                           const Vector& currents) const;
  // Returns Magnets::energy() [J]. Induced magnets are magnetised as if the coils carried no
  // current. `moments` is an initial guess of the induced dipole moments.
  double energy(const Team& team, const CarrierPlaces& places, const Points& moments) const;

  // Advances bodies, circuits and the moments of induced dipoles. `world` must have been built
  // without gravity and gyroscopic torques. Throws SolverFailure if too many sub-steps are needed,
  // if the solve for the magnetisation fails, or if a value is not finite. Throws InvalidInput
  // under the same conditions as MutualInductances::at(), and Unsupported under the same condition
  // as linked_flux().
  MagneticEffort advance(const Team& team, const MagneticStep& step, RigidWorld& world,
                         RigidState& bodies, MagneticState& magnetic);

 private:
  // Poses of the carriers, motion of the obstacles, and time.
  struct Moment {
    CarrierPlaces places;
    const std::vector<Twist>& twists;
    double time;
  };
  // All inputs that determine the actions at an instant.
  struct Cause {
    Points positions;
    Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor> orientations;
    std::vector<RigidPose> obstacles;
    std::vector<std::uint8_t> resting;  // 1: obstacle at rest
    Vector given;                       // (coils) given currents [A]
    bool operator==(const Cause& other) const = default;
  };
  struct Instant {
    Cause cause;
    Magnetised magnetised;
    Actions actions;
  };
  // State at the start of a sub-step. It is saved so that the sub-step can be repeated.
  struct Start {
    RigidState bodies;
    Points momenta;
    MagneticState magnetic;
  };
  struct SubstepResult {
    double obstacle_work = 0.0;  // see MagneticEffort [J]
    double error = 0.0;          // relative_work_error() [1]
  };
  struct Course;

  Cause cause_of(const Moment& moment) const;
  // Computes magnetisation, forces and inductances at an instant. Stores them in last_, whose
  // former contents move to previous_. On entry, `moments` is an initial guess of the induced
  // dipole moments; on return, it contains the computed moments. If last_ already has the same
  // inputs (Cause), changes nothing. Returns last_.
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
  // Instant at the start of the sub-step; empty while last_ is that instant.
  std::optional<Instant> previous_;
};

}  // namespace loomstone
