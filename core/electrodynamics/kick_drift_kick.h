// Steps of a sub-step in which bodies that carry magnets move: kick-drift-kick with world angular
// momentum as the variable. Contacts are answered by the rigid-body world; bodies that touch
// nothing move as if it were not there, so that their linear and angular momentum is kept to
// rounding and their paths are of second order.
//
// With F at the beginning and F' at the end of a sub-step h, the free body has v + h/2 a, then
// moves, then + h/2 a'. The world gets v + h a, so that what rests on something stays at rest; what
// touched goes on from its answer and adds h/2 (a' - a): the momentum is the same.
#pragma once

#include <cstdint>
#include <vector>

#include "core/electrodynamics/magnetic_model.h"

namespace loomstone {

// Bodies within a step; velocities of the state are current, angular velocities are not.
struct MovingBodies {
  RigidState& state;
  Points momenta;  // angular, world axes [kg m^2/s]
};

// Impulses [N s] and angular impulses [N m s] (b x 3) act; of bodies in bearings only their spin
// about the axis is left.
MovingBodies begin_motion(const MagneticModel& model, const Points& impulses,
                          const Points& angular_impulses, RigidState& state);

// The rigid-body world's answer to the whole kick of a sub-step.
struct ContactAnswer {
  RigidState state;
  std::vector<std::uint8_t> touched;  // (b) 1: did not move freely
};
// end: where obstacles are at the end of the sub-step.
ContactAnswer answer_contacts(const MagneticModel& model, double h, const CarrierWrenches& wrenches,
                              const ObstaclePlaces& end, const MovingBodies& bodies,
                              RigidWorld& world);

void half_kick(const MagneticModel& model, double h, const CarrierWrenches& wrenches,
               MovingBodies& bodies);

// Bodies after a half kick by `wrenches`: those that touched something take the world's answer less
// the other half, the others move freely.
void drift(const MagneticModel& model, double h, const CarrierWrenches& wrenches,
           const ContactAnswer& answer, MovingBodies& bodies);

// Angular velocities from momenta. Throws SolverFailure where anything is not finite.
void end_motion(const MagneticModel& model, MovingBodies& bodies);

// The equal parts of a step, short beside the fastest oscillation.
class Substeps {
 public:
  // most: length of a sub-step times the angular frequency [1].
  Substeps(double step, double most) : step_(step), most_(most), limit_(most) {}
  bool left() const { return place_ < parts_; }
  double elapsed() const { return step_ * place_ / parts_; }             // [s]
  double share() const { return static_cast<double>(place_) / parts_; }  // of the step
  double length() const { return step_ / parts_; }                       // [s]
  // Halves what is left until a sub-step resolves the angular frequency [rad/s]; after the first
  // only where it has grown. Throws SolverFailure.
  void resolve(double frequency);
  void pass() { ++place_; }

 private:
  double step_, most_, limit_;
  int parts_ = 1, place_ = 0;  // `place_` of the parts have been passed
};

}  // namespace loomstone
