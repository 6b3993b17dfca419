// Strain limits and contacts together at the end of a step. Limiting and certification alternate:
// certification checks the motion that limiting leaves, limiting repairs the strains that
// certification leaves. Where the two disagree, cloth falls back towards the start of the step,
// where both held. That is a last resort: the caller can take the step in parts instead.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/types.h"
#include "core/cloth/cloth_model.h"
#include "core/cloth/limits/strain_limiter.h"
#include "core/collision/collision_stage.h"
#include "core/parallel/team.h"

namespace loomstone {

struct ConstrainInputs {
  const Team* team = nullptr;
  const Team* collision_team = nullptr;
  const ClothModel* cloth = nullptr;
  StrainLimiter* limiter = nullptr;     // null: no strain is limited
  bool limits_hold = true;              // false: edges are limited, once, before certification
  CollisionStage* collision = nullptr;  // null: nothing collides
  const Tangle* tangle = nullptr;       // of x0, where something collides
  // Near contacts that impulses answer; null: the solve has answered them.
  const std::vector<Contact>* repelled = nullptr;
  std::uint64_t seed = 0;                // of random orders
  double h = 0.0;                        // length of the step [s]
  const Points* x0 = nullptr;            // (all vertices x 3) at the start of the step [m]
  const Vector* inverse_mass = nullptr;  // (all vertices) 0: motion is prescribed [1/kg]
};

struct ConstrainReport {
  LimitReport limits;  // after the first limiting; sweeps and evaluations are those of all rounds
  CertifyReport certified;    // of all rounds, each vertex once; `unresolved` is that of the last
  int rounds = 0;             // certifications
  int fallbacks = 0;          // rounds after cloth fell back for its limits
  bool broke_limits = false;  // limits that held at x0 do not hold at x1
  bool stopped_for_limits = false;  // falling back withheld more than a hundredth of the motion
  double requested = 0.0;  // lengths of the displacements of free cloth before certification [m]
  double withheld_for_limits = 0.0;  // lengths that falling back withholds from them [m]
  double limit_seconds = 0.0;
  std::vector<Index> touched;  // cloth vertices that certification moved
};

// Moves x1 (all vertices x 3) and `bodies` so that no pair intersects on the way from x0 and no
// triangle is beyond its limits by more than limit_margin(). Cloths whose limits sweeps alone
// cannot meet keep an excess, which the report states.
ConstrainReport constrain(const ConstrainInputs& inputs, Points& x1, FreeBodies& bodies);

}  // namespace loomstone
