// Stability limit of symplectic Euler.
#pragma once

#include "core/cloth/cloth_model.h"
#include "core/cloth/elasticity.h"
#include "core/parallel/team.h"

namespace loomstone {

// Returns an estimate of the longest step [s] at which symplectic Euler is stable for small motions
// about x (n x 3) [m]; infinite without cloth, or if stiffness and damping are zero. An oscillator
// with stiffness k and damping d, both divided by its mass, is stable at steps h with
// h^2 k + 2 h d < 4. The estimate uses the largest eigenvalues k and d of all cloth. `elasticity`
// must store all elements of `model`.
double stable_step(Elasticity& elasticity, const ClothModel& model, const Points& x);

// Estimates, for each triangle of this rank, the tangent stiffness of the stretched membrane
// divided by that at rest. Returns the largest of these ratios, or 1 if all are smaller. If e1 >=
// e2 are the principal Green strains of a St. Venant-Kirchhoff membrane, its tangent modulus in the
// direction of e1 is the modulus at rest times 1 + 3 e1 + nu e2. Poisson's ratio nu is at most 1,
// and the estimate replaces nu e2 by max(0, e2). Modes that also shear can be stiffer: in tests,
// stable steps are up to 5 % shorter than the estimate implies. x (n x 3) are positions [m].
double stiffening_of_rank(Elasticity& elasticity, const Team& team, const Points& x);

}  // namespace loomstone
