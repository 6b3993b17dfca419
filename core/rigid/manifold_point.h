// Contact points that the collision algorithms of this directory write directly to Bullet's
// manifolds. Bullet's btManifoldResult joins points that are closer than the contact breaking
// threshold. For contacts ahead of the motion, which bodies reach only during the step, this
// threshold must be as long as the motion, so btManifoldResult would join all points of a small
// fast body.
#pragma once

#include "core/rigid/bullet.h"

namespace loomstone {

// Returns a contact point of the two bodies of a manifold. `normal` points from the second to the
// first body. `on_first` and `on_second` are points on the two bodies, in world coordinates.
btManifoldPoint manifold_point(const btPersistentManifold& manifold, const btVector3& on_first,
                               const btVector3& on_second, const btVector3& normal);
// Makes `point` the continuation of `before`, a point of the previous step: copies the impulses
// from which the solver starts, m_prevRHS and the life time.
void continue_from(const btManifoldPoint& before, btManifoldPoint& point);

}  // namespace loomstone
