// The parts of build(), in the order in which they run.
#pragma once

#include <string>

#include "core/base/find_by_name.h"
#include "core/sim/model/model.h"
#include "core/sim/model/state.h"

namespace loomstone {

// Numbers, names, sizes and references of all descriptions. Throws InvalidInput.
void check_scene(const Scene& scene);

// Cloth rows in bisection order: mechanics, pins, scripts, start positions and velocities.
void build_cloth(const Scene& scene, Model& model, State& state);

// Rigid bodies, obstacles, attachments: surfaces and start poses.
void build_bodies(const Scene& scene, Model& model, State& state);

// Magnets, coils and bearings on bodies and obstacles, and the poles that pictures show.
void build_magnetics(const Scene& scene, Model& model);
void check_magnetics(const Model& model, const State& state);  // where they begin

// Surfaces end to end, thickness, friction, stiffness of contacts.
void build_collision(const Scene& scene, Model& model);

// Refuses a start with intersecting triangles or with cloth inside a closed obstacle or body.
void check_start(const Model& model, const State& state);

// Name of a surface in reports and files: that given, or what it is with its place, or with the
// next number of which no other surface has the name.
std::string name_of(const Scene& scene, const char* kind, std::size_t index, std::size_t count,
                    const std::string& given);

// "cloths[1]" with its name where it has one.
std::string item(const char* list, std::size_t index, const std::string& name);

}  // namespace loomstone
