// A checked scene as tables. Constant once built; together with State it alone decides the future.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/base/frame.h"
#include "core/base/types.h"
#include "core/cloth/cloth_model.h"
#include "core/collision/model/collision_model.h"
#include "core/electrodynamics/magnetic_model.h"
#include "core/rigid/rigid_body.h"
#include "core/sim/scene/scene.h"

namespace loomstone {

// Model.
struct Model {
  // Vertices in collision numbering (cloth rows, then bodies, then obstacles) that belong to one
  // rigid body or obstacle.
  struct Surface {
    Index first = 0;  // collision vertex of its row 0
    Points local;     // (k x 3) body: from the centre of mass; obstacle: mesh vertices [m]
  };
  struct Attached {
    Index row = 0;  // cloth row
    int body = 0;
    Vec3 local = Vec3::Zero();  // point of the body, from its centre, mesh axes [m]
  };
  struct PinScript {  // a cloth whose pins move
    std::vector<Index> rows;
    std::vector<double> times;
    Points positions;  // (times * rows x 3)
  };

  Scene scene;
  ClothModel cloth;
  CollisionModel collision;
  FrameTopology topology;            // user's order
  std::vector<Index> row_of_vertex;  // user's cloth vertex -> row
  std::vector<Index> triangle_of;    // internal triangle -> user's
  std::vector<PinScript> scripts;
  std::vector<Surface> bodies, obstacles;
  std::vector<MassProperties> body_mass;
  std::vector<Attached> attachments;
  double attachment_stiffness = 0.0;     // [N/m]
  std::vector<std::uint8_t> prescribed;  // (rows) 1: cloth vertex whose motion is prescribed
  Vector inverse_mass;      // (collision vertices) of free cloth vertices, else 0 [1/kg]
  double cloth_size = 0.0;  // diagonal of the box about all cloths at the start [m]
  MagneticModel magnetics;  // carriers are bodies, then obstacles

  // Number of a cloth row as the user knows it.
  Index vertex_of_row(Index row) const {
    const auto found = std::find(row_of_vertex.begin(), row_of_vertex.end(), row);
    return static_cast<Index>(found - row_of_vertex.begin());
  }
  Index n_bodies() const { return static_cast<Index>(bodies.size()); }
  Index n_rows() const { return cloth.n_vertices + 2 * n_bodies(); }
};

struct State;

// Checks the scene (throws InvalidInput, Unsupported) and makes model and start state.
void build(const Scene& scene, Model& model, State& state);

}  // namespace loomstone
