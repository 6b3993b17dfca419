// The parts of build(), in the order in which they run.
#pragma once

#include <string>

#include "core/base/error.h"
#include "core/sim/model/model.h"
#include "core/sim/model/state.h"

namespace loomstone {

// Numbers, names, sizes and references of all descriptions. Throws InvalidInput.
void check_scene(const Scene& scene);

// Cloth rows in bisection order: mechanics, pins, scripts, start positions and velocities.
void build_cloth(const Scene& scene, Model& model, State& state);

// Rigid bodies, obstacles, attachments: surfaces and start poses.
void build_bodies(const Scene& scene, Model& model, State& state);

// Magnets on bodies and obstacles, and the field they feel.
void build_magnets(const Scene& scene, Model& model);
void check_magnets(const Model& model, const State& state);  // where they begin

// Coils on bodies and obstacles, and bearings.
void build_coils(const Scene& scene, Model& model);
void check_coils(const Model& model, const State& state);  // where they begin

// Place in the bodies, then obstacles, of one that carries magnets or coils. Throws InvalidInput,
// and Unsupported where it deforms.
std::size_t find_carrier(const Scene& scene, const std::string& name, const std::string& where);

// Surfaces end to end, thickness, friction, stiffness of contacts.
void build_collision(const Scene& scene, Model& model);

// Refuses a start with intersecting triangles or with cloth inside a closed obstacle or body.
void check_start(const Model& model, const State& state);

// Place in a list of descriptions with names. Throws InvalidInput, which lists the names there are.
template <class List>
std::size_t find_by_name(const List& list, const std::string& name, const std::string& where) {
  std::string known;
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (list[i].name == name) return i;
    known += (known.empty() ? "\"" : ", \"") + list[i].name + "\"";
  }
  throw InvalidInput(where + " must be the name of one (" +
                     (known.empty() ? "there are none" : known) + "), got \"" + name + "\"");
}

// Name of a surface in reports and files: that given, or what it is with its place, or with the
// next number of which no other surface has the name.
std::string name_of(const Scene& scene, const char* kind, std::size_t index, std::size_t count,
                    const std::string& given);

// "cloths[1]" with its name where it has one.
std::string item(const char* list, std::size_t index, const std::string& name);

}  // namespace loomstone
