// The parts of build(), in the order in which they run.
#pragma once

#include "core/base/find_by_name.h"
#include "core/sim/model/model.h"
#include "core/sim/model/state.h"
#include "core/sim/scene/check_scene.h"

namespace loomstone {

// Cloth rows in bisection order: mechanics, pins, scripts, start positions and velocities.
void build_cloth(const Scene& scene, Model& model, State& state);

// Rigid bodies, obstacles, attachments: surfaces and start poses.
void build_bodies(const Scene& scene, Model& model, State& state);

// Magnets, coils and bearings on bodies and obstacles, and the poles that pictures show.
void build_magnetics(const Scene& scene, Model& model);
void check_magnetics(const Model& model, const State& state);  // at the start

// Surfaces end to end, thickness, friction, stiffness of contacts.
void build_collision(const Scene& scene, Model& model);

// Refuses a start with intersecting triangles or with cloth inside a closed obstacle or body.
void check_start(const Model& model, const State& state);

}  // namespace loomstone
