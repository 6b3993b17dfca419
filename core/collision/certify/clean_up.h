// Clean-up of impacts by impulses after a step. notes: contact response, recommended step 3.
// Changes little in usual steps and decides fast ones; what it leaves is left to truncation.
#pragma once

#include <vector>

#include "core/collision/certify/impact_search.h"
#include "core/collision/response/impulses.h"

namespace loomstone {

class CleanUp {
 public:
  CleanUp(const CollisionModel& model, const std::vector<SurfacePair>& pairs,
          const Vector& inverse_mass, FreeBodies& bodies)
      : model_(model), pairs_(pairs), impulses_(model, inverse_mass, bodies, true) {}

  // Adds the impacts to those of earlier rounds of the same step and solves them all.
  void solve(const std::vector<StepImpact>& impacts, const Points& x0, Points& x1);

 private:
  const CollisionModel& model_;
  const std::vector<SurfacePair>& pairs_;
  Impulses impulses_;
  std::vector<ImpulseContact> contacts_;
  int round_ = 0;
};

}  // namespace loomstone
