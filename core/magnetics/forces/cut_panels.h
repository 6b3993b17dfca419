// Panels that are cut where the field of another magnet is singular: at the edges of its charged
// faces.
#pragma once

#include <vector>

#include "core/base/rotation.h"
#include "core/magnetics/sources/panel.h"
#include "core/magnetics/sources/source.h"

namespace loomstone {

// Returns triangles that together cover the parallelogram or triangle `panel`. They carry its
// charge density. The planes of the cuboid's faces cut the panel into convex pieces; the triangles
// of a piece share the mean of its corners as first corner, and the opposite edge of each triangle
// is an edge of the piece. The field of a charged face is singular at the face's edges. Where such
// an edge lies on the panel, it therefore coincides with edges u = 1 of triangles. `pose` is the
// pose of the panel in the axes of the cuboid, which is centred at the origin.
std::vector<Panel> cut_along_faces(const Panel& panel, const RigidPose& pose,
                                   const UniformCuboid& cuboid);

// Returns parts that together cover the disc `panel` with its charge density. The planes of the
// cuboid's faces cut the disc along lines, which become edges of the parts. `pose` is the pose of
// the disc's body in the axes of the cuboid.
std::vector<Panel> cut_disc_along_faces(const Panel& panel, const RigidPose& pose,
                                        const UniformCuboid& cuboid);

// Returns parts that together cover the disc `panel` with its charge density. The rims of the
// cylinder or ring, projected along its axis onto the disc, cut the disc. Arcs of the rims become
// edges v = 0 and v = 1 of the parts. A rim that does not surround the axis of the disc cuts
// nothing. Returns no parts if no rim surrounds this axis, or if the angle between the axes is more
// than about 5 degrees. `pose` is the pose of the disc's body in the axes of the cylinder.
std::vector<Panel> cut_along_rims(const Panel& panel, const RigidPose& pose,
                                  const UniformCylinder& cylinder);

}  // namespace loomstone
