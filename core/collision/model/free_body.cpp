#include "core/collision/model/free_body.h"

namespace loomstone {

bool place_body(const CollisionModel& model, const FreeBody& body, const RigidPose& pose,
                Points& x) {
  const CollisionSurface& surface = model.surfaces[body.surface];
  auto rows = x.middleRows(surface.first_vertex, surface.n_vertices);
  const Points before = rows;
  place_points(pose, *body.local, rows);
  return rows != before;
}

}  // namespace loomstone
