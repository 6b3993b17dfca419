// The parts of build(), in the order in which they run.
#pragma once

#include <string>

#include "core/sim/model.h"
#include "core/sim/state.h"

namespace loomstone {

// Numbers, names, sizes and references of all descriptions. Throws InvalidInput.
void check_scene(const Scene& scene);

// Cloth rows in bisection order: mechanics, pins, scripts, start positions and velocities.
void build_cloth(const Scene& scene, Model& model, State& state);

// Rigid bodies, obstacles, attachments: surfaces and start poses.
void build_bodies(const Scene& scene, Model& model, State& state);

// Surfaces end to end, thickness, friction, stiffness of contacts.
void build_collision(const Scene& scene, Model& model);

// Refuses a start with intersecting triangles or with cloth inside a closed obstacle or body.
void check_start(const Model& model, const State& state);

// "cloths[1]" with its name where it has one.
std::string item(const char* list, std::size_t index, const std::string& name);

}  // namespace loomstone
