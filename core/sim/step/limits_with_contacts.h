// Enforces strain limits and contacts together in a part of a step. Limiting and certification
// alternate: certification corrects the motion that limiting leaves, and limiting repairs strains
// that certification causes. If none of four rounds satisfies both, fallbacks move cloth back
// towards the start of the part, where both are usually satisfied. If fallbacks withhold more than
// 1 % of the motion, the part is divided (see bisection.h for exceptions).
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "core/base/types.h"
#include "core/cloth/cloth_model.h"
#include "core/cloth/limits/strain_limiter.h"
#include "core/collision/collision_stage.h"
#include "core/parallel/team.h"

namespace loomstone {

// Energy of the cloth without that of contacts [J].
struct ClothEnergy {
  double kinetic = 0.0, potential = 0.0;
  double total() const { return kinetic + potential; }
};

struct ConstrainInputs {
  const Team* team = nullptr;
  const Team* collision_team = nullptr;
  const ClothModel* cloth = nullptr;
  StrainLimiter* limiter = nullptr;  // null: strain limits are not enforced after the solve
  // false: strain is limited along edges (LimitMethod::Edges). These limits are enforced once,
  // before certification, and neither checked nor enforced again after it.
  bool limits_hold = true;
  bool limits_in_solve = false;  // the solve has limited strain as well
  std::vector<Index> loaded;     // cloth vertices that limiting must not move
  const Communicator* ranks = nullptr;
  CollisionStage* collision = nullptr;  // null: see Engines::collision
  const Tangle* tangle = nullptr;       // tangle at x0; required with `collision`
  // Contacts that impulses resolve; null: the implicit solve resolves contacts.
  const std::vector<Contact>* repelled = nullptr;
  std::uint64_t seed = 0;      // seed of the random orders within sweeps
  double h = 0.0;              // length of the part [s]
  const Points* x0 = nullptr;  // (all vertices x 3) positions at the start of the part [m]
  const Vector* inverse_mass = nullptr;  // (all vertices) [1/kg]; 0 except at free cloth vertices
  double scripted_speed = 0.0;  // largest speed of a prescribed vertex or an obstacle [m/s]
  // (cloth vertices x 3) positions [m] and velocities [m/s] after the solve.
  const Points *x = nullptr, *v = nullptr;
  // Returns the energy of the cloth if the part ends at x1 and the corrections `at_rest` (see
  // ConstrainReport) do not change velocities. Required with `limiter`.
  std::function<ClothEnergy(const Points& x1, const Points& at_rest)> energy;
  double largest_kinetic = 0.0;  // largest kinetic energy so far [J]
};

struct ConstrainReport {
  // Report of the limiting that led to the returned positions. Its numbers of sweeps and
  // evaluations are totals over all limitings of the part.
  LimitReport limits;
  // Merged reports of all certifications and fallbacks up to the certification whose result is
  // used. `unresolved` is that of this certification.
  CertifyReport certified;
  int rounds = 0;                   // number of certifications
  int fallbacks = 0;                // number of fallbacks
  bool broke_limits = false;        // limits satisfied at x0 are exceeded at x1
  bool stopped_for_limits = false;  // fallbacks withheld more than 1 % of the motion
  // Sum of the distances of free cloth vertices from x0 after sweeps and before certification [m].
  double requested = 0.0;
  double withheld_for_limits = 0.0;  // sum of the lengths that fallbacks withhold [m]
  double limited = 0.0;              // energy that sweeps removed from cloth [J]
  // (cloth vertices x 3) Corrections that do not change velocities [m]; empty: none. Limits that
  // act only after the solve may leave an excess, or scripts may force one. If sweeps remove such
  // an excess in one part, the correction divided by the length of the part is not a velocity of
  // the cloth. The same holds for the fraction of corrections by which certification would increase
  // the kinetic energy too much.
  Points at_rest;
  double limit_seconds = 0.0;  // time spent on sweeps of limiting [s]
  double limit_waiting = 0.0;  // part of limit_seconds spent waiting for other ranks [s]
  std::vector<Index> touched;  // cloth vertices that certification moved
};

// Corrects x1 (all vertices x 3) and `bodies` so that the motion from x0 has no impacts and no
// triangle exceeds its limits by more than limit_margin(). Impacts and excess may remain; see
// CertifyReport::unresolved and `broke_limits`.
ConstrainReport constrain(const ConstrainInputs& inputs, Points& x1, FreeBodies& bodies);

}  // namespace loomstone
