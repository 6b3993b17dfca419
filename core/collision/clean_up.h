// Clean-up of impacts by impulses after a step: mass-weighted Gauss-Seidel on linearised gaps with Coulomb friction.
// notes: contact response, recommended step 3. Changes little in usual steps and decides fast ones; what it leaves is left
// to truncation.
#pragma once

#include <vector>

#include "core/collision/impact_search.h"

namespace loomstone {

class CleanUp {
 public:
  CleanUp(const CollisionModel& model, const std::vector<SurfacePair>& pairs) : model_(model), pairs_(pairs) {}

  // Adds the impacts to those of earlier rounds of the same step and solves them all. Vertices without inverse mass stay.
  void solve(const std::vector<StepImpact>& impacts, const Points& x0, const Vector& inverse_mass, Points& x1);

 private:
  struct Constraint {
    ContactKind kind;
    PairKey key;
    std::array<Index, 4> vertices;
    std::array<double, 4> weights;
    Vec3 normal;
    double inverse_mass;           // sum of w^2 / m [1/kg]
    double target, largest_change; // [m]
    double friction;
    double pressed = 0.0;          // impulse times h along the normal [kg m]
    Vec3 dragged = Vec3::Zero();   // across it [kg m]
  };
  const CollisionModel& model_;
  const std::vector<SurfacePair>& pairs_;
  std::vector<Constraint> constraints_;
};

}  // namespace loomstone
