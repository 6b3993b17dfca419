// A frame is the data of one instant of a run, for the cache and the renderer. Vertices and
// triangles are in the user's order. Arrays of cloth concatenate all cloths. Arrays of bodies
// concatenate all rigid bodies, followed by all obstacles.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/look.h"
#include "core/base/report.h"
#include "core/base/types.h"

namespace loomstone {

// Frame data that is constant over a run.
struct FrameTopology {
  Triangles triangles;                   // (m x 3) cloth triangles
  Points2 corner_uv;                     // (3m x 2) rest coordinates of each triangle corner [m]
  std::vector<Index> cloth_of_triangle;  // (m) index into cloth_names
  std::vector<Index> cloth_of_vertex;    // (n) index into cloth_names
  std::vector<std::string> cloth_names;
  Triangles body_triangles;                 // (mb x 3) triangles of rigid bodies and obstacles
  std::vector<Index> body_of_triangle;      // (mb) index into body_names
  std::vector<Index> body_of_vertex;        // (nb) index into body_names
  std::vector<std::string> body_names;      // rigid bodies first, then obstacles
  std::vector<std::uint8_t> body_is_floor;  // (bodies) 1: rendered as ground
  // (nb) Magnetic polarity [1]: positive on the north side and negative on the south side of a
  // magnet, 0 away from magnets; see pole_at() in core/electrodynamics/magnetic_model.h. Empty
  // without magnets.
  std::vector<double> body_pole;
  std::vector<Look> cloth_looks, body_looks;  // (cloths) and (bodies); empty if none has a look
  // (3mb x 2) uv of each corner of body_triangles [m], zeros for bodies without a texture. Empty if
  // no body has a texture.
  Points2 body_corner_uv;

  std::size_t bytes() const {
    return bytes_of(triangles, corner_uv, cloth_of_triangle, cloth_of_vertex, body_triangles,
                    body_of_triangle, body_of_vertex, body_pole, body_corner_uv);
  }
};

struct Frame {
  double time = 0.0;  // [s]
  std::int64_t step = 0;
  Points positions;   // (n x 3) [m]
  Points velocities;  // (n x 3) [m/s]
  Points strain;      // (m x 3) Green strain: weft, warp, shear (E12) [1]
  Vector stretch;     // (m) largest principal stretch [1]
  // (n) 2: on an intersecting triangle that is listed in StepOutcome::forced
  // (core/sim/step/step_outcome.h). Other vertices: 1 if in contact in some part of the last step,
  // otherwise 0.
  std::vector<std::uint8_t> contact;
  Points body_vertices;  // (nb x 3) positions [m]
  Vector coil_currents;  // (coils) [A]
  StepReport report;
};

}  // namespace loomstone
