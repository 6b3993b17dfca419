// Curves, such as field lines, drawn as round tubes together with the bodies.
#pragma once

#include "renderer/mesh_buffers.h"
#include "renderer/renderer.h"

namespace loomstone {

// Bodies and tubes as one drawn mesh, whose last part contains the tubes. Vertices and values of
// the tubes follow those of the bodies.
struct BodiesAndTubes {
  DrawnMesh mesh;
  Points positions;  // [m]
  Vector values;     // magnetic polarity at the bodies' vertices, then values of the curves
};

// Joins the meshes of bodies and curves. The vertices of the bodies in the first frame,
// `first_bodies`, determine which edges of the bodies are sharp.
BodiesAndTubes bodies_and_tubes(const FrameTopology& topology, const Points& first_bodies,
                                const Points& body_vertices, const Curves& curves);

}  // namespace loomstone
