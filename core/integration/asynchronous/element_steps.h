// Stable steps of the triangles of the membrane, at rest and stretched.
#pragma once

#include <array>
#include <vector>

#include "core/cloth/cloth_model.h"
#include "core/cloth/elasticity.h"
#include "core/integration/options.h"

namespace loomstone {

// LimitMode::phase() of each of the three limit modes of a triangle: 0, 1 or 2.
using LimitPhases = std::array<std::uint8_t, 3>;

// Returns the phases of the triangle in one lane of a batch. `entered` points to the entries of the
// batch in membrane::Tables::entered (core/cloth/membrane/membrane_kernels.h).
inline LimitPhases phases_of_lane(const std::uint8_t* entered, int lane) {
  LimitPhases phases;
  for (int k = 0; k < 3; ++k)
    phases[k] =
        static_cast<std::uint8_t>((entered[2 * k] >> lane & 1) + (entered[2 * k + 1] >> lane & 1));
  return phases;
}

// Consider triangle K alone, with the mass that K contributes to each of its corners. An explicit
// step h is stable for K if h^2 lambda + 2 h delta <= 4, where lambda [1/s^2] and delta [1/s] are
// the largest eigenvalues of stiffness and of viscosity, both divided by mass. The largest
// eigenvalue of the whole cloth is at most the largest eigenvalue of its triangles [Fried1972]. The
// step of a triangle satisfies h^2 lambda + 2 h delta = 4 safety^2, with Element::safety. With a
// limit potential, it can be shorter; see at().
class ElementSteps {
 public:
  // limits (m): modes of the limit potential; may be empty.
  ElementSteps(const ClothModel& model, const Asynchronous& options,
               const std::vector<LimitModes>& limits = {});

  const Vector& at_rest() const { return at_rest_; }  // (m) steps at rest [s]
  // Steps (m) [s] at positions x and velocities v, never longer than at rest. They use the bounds
  // lambda <= s^2 lambda_0 + gamma t and delta <= s^2 delta_0, where s >= 1 is the largest stretch,
  // t [N/m] is the largest tension, and gamma is the largest eigenvalue that a unit of tension
  // adds. delta_0 is the value at rest. lambda_0 is the eigenvalue at rest plus the largest
  // eigenvalue that the stiff phases of the limit modes add. Each mode counts as being in the
  // higher of two phases: that at x, and that at the positions that v predicts after the longest
  // step at rest of all triangles. With a limit potential, steps are also so short that no strain
  // component is predicted to change by more than 0.1 in a step. The result is valid until the next
  // call.
  const Vector& at(const Team& team, const Points& x, const Points& v, Elasticity& elasticity);
  // Step of triangle t [s], for the strains at the positions x of the last call of at() or
  // first_unstable(). Each limit mode counts as being in the higher of two phases: its phase at
  // these strains, and its entry of `phases`. The change of strain does not limit this step.
  double step_in_phases(Index t, const LimitPhases& phases) const;
  // Returns the first triangle whose strain at x is not finite or whose step in `steps` (m) [s] is
  // longer than its stability limit; -1 if there is none.
  Index first_unstable(const Team& team, const Points& x, const Vector& steps,
                       Elasticity& elasticity);
  // Mass that triangle t contributes to its corner k, as a fraction of the vertex's mass [1].
  double share(Index t, int k) const { return share_(t, k); }

 private:
  struct Element {
    double eigenvalue, tension_eigenvalue, viscous_eigenvalue;  // [1/s^2], [1/kg], [1/s]
    double safety;  // step without viscosity, as a fraction of the stability limit [1]
  };
  void measure(const Team& team, const Points& x, Elasticity& elasticity);
  // Step of a triangle with the measured strain and the given phases [s].
  double step(Index t, const LimitPhases& phases, double safety) const;
  double largest_of_phases(Index t, const LimitPhases& phases) const;
  LimitPhases phases_at(Index t, const Points& green) const;

  const ClothModel& model_;
  std::vector<LimitModes> limits_;  // (m) modes of the limit potential; empty: none
  // (m) limit_products() (element_steps.cpp) divided by mass [1/s^2]; empty without a limit
  // potential.
  std::vector<Mat3> limit_products_;
  std::vector<Element> elements_;
  Points share_;
  Vector at_rest_, at_;
  // Positions at the last call of measure() (n x 3) [m], and the Green strains there (m x 3) [1].
  Points x_, green_;
  Vector stretch_, tension_;
  std::vector<LimitPhases> phases_;  // (m) phases at x_
  Points next_x_, next_green_;
  Vector next_stretch_;
};

}  // namespace loomstone
