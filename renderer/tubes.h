// Curves drawn as round tubes among the bodies, field lines above all.
#pragma once

#include "renderer/mesh_buffers.h"
#include "renderer/renderer.h"

namespace loomstone {

// Bodies and tubes as one drawn mesh: rows of the tubes' vertices and values follow those of the
// bodies.
struct BodiesAndTubes {
  DrawnMesh mesh;
  Points positions;  // [m]
  Vector values;     // poles of bodies; of tubes the curves' own
};

// Edges are sharp where those of `first_bodies` are.
BodiesAndTubes bodies_and_tubes(const FrameTopology& topology, const Points& first_bodies,
                                const Points& body_vertices, const Curves& curves);

}  // namespace loomstone
