// Longest stable steps of the triangles of the membrane, at rest and stretched.
#pragma once

#include <vector>

#include "core/cloth/cloth_model.h"
#include "core/cloth/elasticity.h"
#include "core/integration/options.h"

namespace loomstone {

// Let f_K be the force of triangle K on its corners, each with the mass that K adds to the vertex.
// An explicit step h is stable for K if h^2 lambda + 2 h delta <= 4, with the largest eigenvalues
// lambda of stiffness and delta of viscosity, both divided by mass. The largest eigenvalue of the
// whole cloth is at most the largest of a triangle [Fried1972]. A step takes the share `safety` of
// the bound: h^2 lambda + 2 h delta = 4 safety^2.
class ElementSteps {
 public:
  ElementSteps(const ClothModel& model, const Asynchronous& options);

  const Vector& at_rest() const { return at_rest_; }  // (m) [s]
  // Steps at positions x (m) [s]; at most those at rest. With principal stretch s and largest
  // tension t [N/m], lambda <= s^2 lambda_0 + gamma t, where gamma is the largest eigenvalue per
  // unit of tension. Valid until the next call.
  const Vector& at(const Team& team, const Points& x, Elasticity& elasticity);
  // First triangle whose strain at x is not finite, or for which steps (m) exceed the bound itself;
  // -1 if there is none.
  Index first_unstable(const Team& team, const Points& x, const Vector& steps,
                       Elasticity& elasticity);
  // Share of triangle t in the mass of its corner k [1].
  double share(Index t, int k) const { return share_(t, k); }

 private:
  struct Element {
    double eigenvalue, tension_eigenvalue, viscous_eigenvalue;  // [1/s^2], [m/kg], [1/s]
    double safety;                                              // share of the bound [1]
  };
  void measure(const Team& team, const Points& x, Elasticity& elasticity);
  double step(const Element& element, double stretch_square, double tension, double safety) const;

  const ClothModel& model_;
  std::vector<Element> elements_;
  Points share_;
  Vector at_rest_, at_;
  Points x_, green_;  // positions of the strains, and the strains
  Vector stretch_, tension_;
};

}  // namespace loomstone
