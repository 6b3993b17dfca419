// Gives obstacles whose names are not chosen by the user different names.
#pragma once

#include "core/sim/scene/scene.h"

namespace loomstone {

// Appends the smallest free number >= 2, as in sphere_2, to the name of each obstacle that is
// `numbered` and has the name of another surface. The names depend only on the scene, and a second
// call changes nothing.
void number_names(Scene& scene);

}  // namespace loomstone
