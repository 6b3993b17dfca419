// Motion of Bullet's shapes in a step in which nothing touches their bodies.
#pragma once

#include "core/rigid/bullet.h"

namespace loomstone {

// Returns the pose of a shape after the given share [1] of a step [s] in which nothing touches its
// body.
btTransform pose_after(const btCollisionObjectWrapper& shape, btScalar step, btScalar share = 1.0);
// Returns the motion of the second object relative to the first, in the axes of the first, for a
// step in which nothing touches the two objects.
btTransform relative_motion(const btCollisionObjectWrapper& first,
                            const btCollisionObjectWrapper& second, btScalar step);
// Returns an upper bound [m] on the distance by which `motion` moves any point of a shape. `motion`
// is given in the axes of the shape.
double largest_motion(const btCollisionShape& shape, const btTransform& motion);
// Returns half the smallest side of the shape's bounding box in its own axes [m].
double inner_radius(const btCollisionShape& shape);

}  // namespace loomstone
