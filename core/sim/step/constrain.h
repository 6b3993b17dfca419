// Strain limits and contacts together at the end of a step: what limiting moves is certified, what
// certification moves is limited again, and where the two do not agree cloth goes back towards the
// start of the step, where both held: a last resort, since the caller can take the step in parts.
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
  StrainLimiter* limiter = nullptr;  // null: no strain is limited
  bool limits_hold = true;  // false: limiting is not of triangles' strains, and comes first alone
  CollisionStage* collision = nullptr;  // null: nothing collides
  const Tangle* tangle = nullptr;       // of x0, where something collides
  const std::vector<Contact>* repelled =
      nullptr;            // near contacts that impulses answer; null: the solve has answered them
  std::uint64_t key = 0;  // of random orders
  double step = 0.0;      // h [s]
  const Points* x0 = nullptr;            // (all vertices x 3) at the start of the step [m]
  const Vector* inverse_mass = nullptr;  // (all vertices) 0: moves by script [1/kg]
};

struct ConstrainReport {
  LimitReport limits;  // right after limiting; sweeps and evaluations are those of all rounds
  CertifyReport
      certified;       // over all rounds, each vertex once, but for `unresolved`: of the last one
  int rounds = 0;      // of certification
  int retreats = 0;    // of these, those after corners went back
  bool broke = false;  // limits that held at x0 do not hold at x1
  bool stopped =
      false;  // cloth went back for its limits, and lost more than a hundredth of its motion by it
  double wanted = 0.0;  // lengths of the displacements of free cloth that came to certification [m]
  double gone_back = 0.0;  // of these, lengths that corners went back for their limits [m]
  double limit_seconds = 0.0;
  std::vector<Index> touched;  // cloth vertices that certification moved
};

// x1 (all vertices x 3) and `bodies` move so that no pair intersects on the way from x0 and no
// triangle is beyond its limits by more than limit_margin(), on cloths whose limits sweeps alone
// can meet.
ConstrainReport constrain(const ConstrainInputs& inputs, Points& x1, FreeBodies& bodies);

}  // namespace loomstone
