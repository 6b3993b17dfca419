// Stability limit of symplectic Euler.
#pragma once

#include "core/cloth/cloth_model.h"

namespace loomstone {

// Returns an estimate of the longest step [s] at which symplectic Euler is stable for small motions
// about x (n x 3) [m], or infinity without stiffness and damping. An oscillator with stiffness k
// and damping d, both divided by its mass, is stable if h^2 k + 2 h d < 4. The estimate uses the
// largest eigenvalues k and d of all cloth.
double stable_step(const ClothModel& model, const Points& x);

}  // namespace loomstone
