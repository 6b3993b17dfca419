// Converts recipes (SourceRecipe: how a source or magnetisable body was made) to and from Python
// tuples, and tuples to poses. These functions are used to pickle sources and magnetisable bodies.
#pragma once

#include "bindings/bindings.h"
#include "core/electrodynamics/source_recipes.h"

namespace loomstone {

inline py::tuple state_of(const SourceRecipe& recipe) {
  if (recipe.kind.empty())
    throw Unsupported(
        "a body with induced magnetisation cannot be pickled; pickle its SoftBody and induce() "
        "again");
  const py::object of = recipe.of ? py::object(state_of(*recipe.of)) : py::none();
  return py::make_tuple(recipe.kind, recipe.values, recipe.mesh, of);
}

inline SourceRecipe recipe_of(const py::tuple& state) {
  SourceRecipe recipe;
  recipe.kind = state[0].cast<std::string>();
  recipe.values = state[1].cast<decltype(recipe.values)>();
  recipe.mesh = state[2].cast<std::shared_ptr<const TriangleMesh>>();
  if (!state[3].is_none())
    recipe.of = std::make_shared<const SourceRecipe>(recipe_of(state[3].cast<py::tuple>()));
  return recipe;
}

inline RigidPose pose_of(const py::tuple& state, std::size_t first) {
  return {state[first].cast<Vec3>(), state[first + 1].cast<Vec4>()};
}

}  // namespace loomstone
