// Tables of a checked scene. They are constant after build(). Together with State and the options
// of the integrator, they determine all later steps, under the condition given in state.h.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/event_motion.h"
#include "core/base/frame.h"
#include "core/base/types.h"
#include "core/cloth/cloth_model.h"
#include "core/collision/model/collision_model.h"
#include "core/electrodynamics/magnetic_model.h"
#include "core/rigid/rigid_body.h"
#include "core/sim/scene/scene.h"

namespace loomstone {

struct Model {
  // The collision vertices of one rigid body or obstacle. Collision vertices are numbered in this
  // order: cloth rows, vertices of bodies, vertices of obstacles.
  struct Surface {
    Index first = 0;  // index of its first vertex among all collision vertices
    // (k x 3) Vertices in the axes of the mesh [m], relative to the body's centre of mass or to the
    // origin of the obstacle's mesh.
    Points local;
  };
  struct PinScript {  // scripted positions of the pins of one cloth
    std::vector<Index> rows;
    std::vector<double> times;
    Points positions;  // (times * rows x 3) [m]; the positions of one time are consecutive
  };

  Scene scene;
  ClothModel cloth;
  CollisionModel collision;
  FrameTopology topology;            // without the cloth tables that frame_topology() adds
  std::vector<Index> row_of_vertex;  // row of each cloth vertex; vertices in the user's order
  std::vector<Index> triangle_of;    // user's index of each triangle of cloth.triangles
  std::vector<PinScript> scripts;
  std::vector<Surface> bodies, obstacles;
  std::vector<MassProperties> body_mass;
  std::vector<AttachedVertex> attachments;
  double attachment_stiffness = 0.0;     // [N/m]
  std::vector<std::uint8_t> prescribed;  // (rows) 1: prescribed vertex
  Vector inverse_mass;      // (collision vertices) nonzero only for free cloth vertices [1/kg]
  double cloth_size = 0.0;  // diagonal of the bounding box of all cloths at the start [m]
  // Magnets, coils and bearings. The index `carrier` of a magnet or coil counts the bodies, then
  // the obstacles.
  MagneticModel magnetics;

  // Returns the user's index, over all cloths, of the vertex of a cloth row.
  Index vertex_of_row(Index row) const {
    const auto found = std::find(row_of_vertex.begin(), row_of_vertex.end(), row);
    return static_cast<Index>(found - row_of_vertex.begin());
  }
  // Returns the memory of the tables of cloth, pin scripts and frames [bytes]. Does not count the
  // scene with its meshes, the collision model, and the data of bodies, obstacles and magnets.
  std::size_t bytes() const {
    std::size_t sum =
        bytes_of(cloth, topology, row_of_vertex, triangle_of, prescribed, inverse_mass);
    for (const PinScript& script : scripts) sum += bytes_of(script.rows, script.positions);
    return sum;
  }
  Index n_bodies() const { return static_cast<Index>(bodies.size()); }
  Index n_rows() const { return cloth.n_vertices + 2 * n_bodies(); }
};

struct State;

// Returns the topology of frames, in the user's order. Its cloth tables are built from the scene in
// each call, so that only processes that need the topology store these tables.
FrameTopology frame_topology(const Model& model);

// Checks the scene and builds the model and the start state. Throws InvalidInput or Unsupported.
void build(const Scene& scene, Model& model, State& state);

}  // namespace loomstone
