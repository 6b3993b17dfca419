// What happened in a step, for people, plots and the cache. A report never decides anything.
#pragma once

#include <array>
#include <cstdint>

namespace loomstone {

// Stages of a step in the order of core/sim/step/stepper.cpp.
enum class StageName : int { Loads, Proximity, Integrate, Bodies, Limit, Certify, Check, Count };
inline constexpr std::array<const char*, 7> stage_names = {
    "loads", "proximity", "integrate", "bodies", "limit", "certify", "check"};

struct StepReport {
  std::int64_t step = 0;
  double time = 0.0;                // at the end of the step [s]
  std::array<double, 7> seconds{};  // wall time per stage [s]
  // Time that the threads spent in the loops of collision detection and response: least, mean and
  // most of a thread [s].
  double busy_least = 0.0, busy_mean = 0.0, busy_most = 0.0;
  int newton_iterations = 0;     // outer iterations (1 for linearised schemes)
  int linear_iterations = 0;     // of the linear solver, summed over outer iterations
  double linear_residual = 0.0;  // of the last linear solve, relative [1]
  std::int64_t contacts = 0;     // proximity contacts that entered the solve
  std::int64_t impacts = 0;      // hits of the continuous test, first pass
  std::int64_t truncated = 0;    // vertices whose displacement was shortened
  int substeps = 1;  // parts the step was taken in: more where certification or the solver failed
                     // at its full length
  std::int64_t unresolved = 0;  // impacts that certification had to leave, even in 1/64 of the step
  std::int64_t intersections =
      0;  // intersecting triangle pairs at the end; counted from an unresolved step on until 0
  std::int64_t forced = 0;  // of these, pairs left where what moves by script leaves cloth no room
  double wanted_motion =
      0.0;  // lengths of the displacements that came to certification, of cloth that is free [m]
  double withheld_motion =
      0.0;  // lengths that truncation took from the displacements of cloth and free bodies [m]
  double withheld = 0.0;            // withheld_motion over wanted_motion [1]
  double truncated_momentum = 0.0;  // mass times change of velocity by truncation, sizes summed
                                    // over vertices and bodies [kg m/s]
  double contact_acceleration =
      0.0;  // root mean square over free vertices in contact, over the whole step [m/s^2]
  int limit_sweeps = 0;  // of strain limiting
  int rate_sweeps = 0;   // of strain-rate limiting
  int limit_rounds =
      0;  // certifications of a part of the step, in turn with limiting; the most of a part
  int limit_retreats =
      0;  // of these, those after cloth went back towards the start of the step for its limits
  std::int64_t limit_evaluations =
      0;                      // elements whose strain was computed in the sweeps of strain limiting
  double limit_excess = 0.0;  // largest strain beyond its limit right after limiting [1]
  double weft_excess =
      0.0;  // largest strain beyond its limit at the end of the step, along weft [1]
  double warp_excess = 0.0;
  double shear_excess = 0.0;
  std::int64_t beyond_limit =
      0;  // elements beyond a limit by more than the tolerance at the end of the step
  std::int64_t worst_element =
      -1;  // the one most beyond, in the user's numbering over all cloths; -1: none
  std::int64_t broken_limits =
      0;  // elements beyond a limit by more than contacts may leave, limit_margin()
  double weft_strain =
      0.0;  // largest strain U - I of all triangles at the end of the step, limited or not [1]
  double warp_strain = 0.0;
  double shear_strain = 0.0;    // of its absolute values
  double max_stretch = 1.0;     // largest principal stretch of any triangle [1]
  double kinetic_energy = 0.0;  // [J], as all energies
  double membrane_energy = 0.0;
  double bending_energy = 0.0;
  double gravity_energy = 0.0;
  double contact_energy = 0.0;       // at the start of the step; the others at its end
  double body_kinetic_energy = 0.0;  // of rigid bodies, moving and turning
  double body_gravity_energy = 0.0;  // of rigid bodies
  double magnetic_energy = 0.0;      // of magnets in one another's field and in the uniform one
  int magnetic_substeps = 0;         // that the magnets' motion took
  double magnetic_error = 0.0;   // largest estimated error of a force at the end of the step [N]
  double circuit_current = 0.0;  // in the first circuit at the end of the step [A]
  double circuit_energy = 0.0;   // of the inductances of all circuits, own and mutual
  double circuit_heat = 0.0;     // in their resistances since the start
  double circuit_supply = 0.0;   // by the sources of all coils since the start
  double bearing_work = 0.0;     // taken out by friction and torques of bearings since the start
};

}  // namespace loomstone
