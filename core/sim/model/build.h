// Functions with which build() fills and checks the model and the start state.
#pragma once

#include "core/base/find_by_name.h"
#include "core/sim/model/model.h"
#include "core/sim/model/state.h"
#include "core/sim/scene/check_scene.h"

namespace loomstone {

// Orders the rows of each cloth by recursive graph bisection, and its triangles by their smallest
// row. Sets the materials, pins, scripts, start positions, start velocities, names and looks of
// cloth. frame_topology() adds the other tables of cloth that frames need.
void build_cloth(const Scene& scene, Model& model, State& state);

// Sets the surfaces, start state, looks and frame topology of rigid bodies and obstacles, the mass
// properties of bodies, and the attachments.
void build_bodies(const Scene& scene, Model& model, State& state);

// Sets the uniform magnetic field, magnets, coils and bearings. If there are magnets, also sets the
// polarity at each vertex of bodies and obstacles, for rendering.
void build_magnetics(const Scene& scene, Model& model);
// Checks magnets, magnetisable bodies and circuits at the start positions; see
// check_magnetic_start().
void check_magnetics(const Model& model, const State& state);

// Sets the collision model, including the contact stiffness and the thickness and friction of each
// surface.
void build_collision(const Scene& scene, Model& model);

// Sets CollisionModel::attached from the start positions. Needs the other members of the
// collision model.
void build_attached_contacts(const State& state, Model& model);

// Throws InvalidInput if cloth intersects a surface at the start or lies inside a closed obstacle
// or body, unless the scene allows initial intersections or disables collisions.
void check_start(const Model& model, const State& state);

}  // namespace loomstone
