// Stages of a sub-step in which the bodies of a scene with magnets, coils or bearings move. The
// integrator is kick-drift-kick (Stoermer-Verlet). Its rotational variable is the angular momentum
// in world axes. RigidWorld resolves contacts and does not influence bodies that are not in
// contact. The magnetic forces between such bodies conserve their total linear and angular momentum
// up to rounding. The paths of these bodies are second-order accurate.
//
// Let v be the velocity at the start of a sub-step of length h, and a and a' the accelerations at
// its start and end. The velocity of a free body changes by a h/2 before the drift and by a' h/2
// after it. RigidWorld adds a h to v before it resolves contacts, so resting bodies stay at rest.
// The new velocity of a body in contact is the one that RigidWorld returns plus (a' - a) h/2. The
// forces thus change its momentum as much as that of a free body. For bodies that press on each
// other, shared_kicks.h replaces (a' - a) h/2.
#pragma once

#include <cstdint>
#include <vector>

#include "core/electrodynamics/magnetic_model.h"
#include "core/electrodynamics/pressed_groups.h"

namespace loomstone {

// Bodies during a step. The linear velocities in `state` are up to date, but the angular velocities
// are not: they must be computed from `momenta`.
struct MovingBodies {
  RigidState& state;
  Points momenta;  // angular momenta, world axes [kg m^2/s]
};

// Applies the impulses at the start of a step to `state` and returns it with the angular momenta.
// Bodies in bearings keep only their rotation about the axis of the bearing.
MovingBodies begin_motion(const MagneticModel& model, const BodyImpulses& impulses,
                          RigidState& state);

// Result of answer_contacts(): the bodies after RigidWorld has advanced them by the whole sub-step.
struct ContactAnswer {
  RigidState state;
  std::vector<std::uint8_t> touched;  // (bodies) 1: the body did not move freely
  std::vector<PressedGroup> groups;
  BodyImpulses without;  // momenta at the end of the sub-step, as if there were no contacts
};

// Applies the impulses at the end of a step to the bodies that move freely. answer_contacts() must
// have received the same impulses, so the velocities of bodies in contact already contain them.
void end_impulses(const MagneticModel& model, const BodyImpulses& impulses,
                  const ContactAnswer& answer, MovingBodies& bodies);
// Further inputs of answer_contacts(): the impulses at the start of this sub-step, which the
// velocities and momenta already contain, the impulses at its end, and the places of the
// obstacles at its end. The impulses at the start are zero except in the first sub-step of a step,
// and those at the end are zero except in the last.
struct SubstepConditions {
  const BodyImpulses &at_start, &at_end;
  const ObstaclePlaces& end;
};
// Advances copies of the bodies by RigidWorld, which applies `wrenches`, gravity and the impulses
// for the whole sub-step h [s] and resolves contacts.
ContactAnswer answer_contacts(const MagneticModel& model, double h, const CarrierWrenches& wrenches,
                              const SubstepConditions& inputs, const MovingBodies& bodies,
                              RigidWorld& world);

void half_kick(const MagneticModel& model, double h, const CarrierWrenches& wrenches,
               MovingBodies& bodies);

// Moves the bodies after a half kick by `wrenches`. The velocities of bodies in contact are the
// result of RigidWorld minus a second half kick by `wrenches`. Bodies without contact move freely.
void drift(const MagneticModel& model, double h, const CarrierWrenches& wrenches,
           const ContactAnswer& answer, MovingBodies& bodies);

// Returns the kinetic energy of the bodies [J].
double kinetic_energy(const MagneticModel& model, const MovingBodies& bodies);

// Computes angular velocities from momenta. Throws SolverFailure if a position, velocity or
// momentum is not finite.
void end_motion(const MagneticModel& model, MovingBodies& bodies);

// Divides a step into sub-steps that are short compared with the period of the fastest oscillation,
// and in which magnets and coils move by a small fraction of the distance between them.
class Substeps {
 public:
  // `most` is the limit of sub-step length times angular frequency, and of sub-step length times
  // rate of relative motion [1].
  Substeps(double step, double most) : step_(step), most_(most), limit_(most) {}
  bool left() const { return place_ < parts_; }
  bool first() const { return place_ == 0; }
  bool last() const { return place_ + 1 == parts_; }
  double elapsed() const { return step_ * place_ / parts_; }  // [s]
  // Elapsed fraction of the step, now and after one more sub-step.
  double share() const { return static_cast<double>(place_) / parts_; }
  double next_share() const { return static_cast<double>(place_ + 1) / parts_; }
  double length() const { return step_ / parts_; }  // [s]
  // Halves the length of the remaining sub-steps until they resolve the angular frequency [rad/s].
  // From the second call on, length times frequency may exceed the limit by up to a third. Throws
  // SolverFailure if more than 4,096 sub-steps per step are needed or the frequency is not finite.
  void resolve(double frequency);
  // Largest rate of relative motion that the remaining sub-steps resolve [1/s].
  double resolved_motion() const { return most_ / length(); }
  // Halves the length of the remaining sub-steps until they resolve the rate of relative motion
  // [1/s], but makes no more than 4,096 sub-steps per step.
  void follow(double motion_rate);
  // Halves the length of the remaining sub-steps. Returns false, without effect, if there would be
  // more than 4,096 sub-steps per step.
  bool halve();
  void pass() { ++place_; }

 private:
  double step_, most_, limit_;
  // parts_: sub-steps of the present length per step; place_: how many of them have elapsed.
  int parts_ = 1, place_ = 0;
};

}  // namespace loomstone
