// Comparison of recipes, and functions that recreate sources and magnetisable bodies from them.
// Results of recreated sources and bodies are bitwise identical to those of the originals, except
// that a CellMagnet is recreated without its expansion.
#pragma once

#include "core/magnetics/induction/soft_shape.h"

namespace loomstone {

bool operator==(const SourceRecipe& a, const SourceRecipe& b);

// make_source() and make_soft_shape() throw InvalidInput if the recipe is unknown, is incomplete or
// has an invalid value.
SourcePtr make_source(const SourceRecipe& recipe);
SoftShapePtr make_soft_shape(const Team& team, const SourceRecipe& recipe);

}  // namespace loomstone
