// Sources and bodies that magnetise from their recipes: equality, and the same made again, to the
// last bit.
#pragma once

#include "core/magnetics/induction/soft_shape.h"

namespace loomstone {

bool operator==(const SourceRecipe& a, const SourceRecipe& b);

// Throw InvalidInput for recipes that nothing was made from.
SourcePtr make_source(const SourceRecipe& recipe);
SoftShapePtr make_soft_shape(const Team& team, const SourceRecipe& recipe);

}  // namespace loomstone
