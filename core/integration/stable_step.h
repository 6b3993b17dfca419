// Stability limit of symplectic Euler.
#pragma once

#include "core/cloth/cloth_model.h"

namespace loomstone {

// Returns the longest step at which symplectic Euler is stable for small motions about x (n x 3)
// [s], or infinity without stiffness and damping. An oscillator with stiffness k and damping d,
// both divided by its mass, is stable if h^2 k + 2 h d < 4. Here k and d are the largest
// eigenvalues of all cloth.
double stable_step(const ClothModel& model, const Points& x);

}  // namespace loomstone
