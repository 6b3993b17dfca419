// Clean-up: resolves the impacts of a step by impulses (method.md, Clean-up). Certification then
// withholds motion for the impacts that remain.
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

  // Performs one round of clean-up: adds `impacts` to the impacts of earlier rounds of the same
  // step and solves for all of them. Corrects x1 and the end poses of bodies.
  void solve(const std::vector<StepImpact>& impacts, const Points& x0, Points& x1);

 private:
  const CollisionModel& model_;
  const std::vector<SurfacePair>& pairs_;
  Impulses impulses_;
  std::vector<ImpulseContact> contacts_;
  int round_ = 0;
};

}  // namespace loomstone
