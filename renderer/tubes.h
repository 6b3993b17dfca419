// Curves, such as field lines, drawn as round tubes together with the bodies.
#pragma once

#include "renderer/mesh_buffers.h"
#include "renderer/renderer.h"

namespace loomstone {

// Bodies and tubes as one drawn mesh. Vertices and values of the tubes follow those of the bodies.
struct BodiesAndTubes {
  DrawnMesh mesh;
  Points positions;  // [m]
  Vector values;     // poles of bodies, then values of curves
};

// Which edges are sharp follows from `first_bodies`, the bodies' vertices in the first frame.
BodiesAndTubes bodies_and_tubes(const FrameTopology& topology, const Points& first_bodies,
                                const Points& body_vertices, const Curves& curves);

}  // namespace loomstone
