// Gives different names to obstacles whose names the user has not chosen.
#pragma once

#include "core/sim/scene/scene.h"

namespace loomstone {

// Appends the smallest free number >= 2, as in sphere_2, to the name of each obstacle that is
// `numbered` and whose name is already taken. If the name already ends with an underscore and a
// number, the new number replaces that one. Empty names stay empty. The names depend only on the
// scene, and a second call changes nothing.
void number_names(Scene& scene);

}  // namespace loomstone
