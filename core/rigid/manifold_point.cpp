#include "core/rigid/manifold_point.h"

namespace loomstone {

btManifoldPoint manifold_point(const btPersistentManifold& manifold, const btVector3& on_first,
                               const btVector3& on_second, const btVector3& normal) {
  const btCollisionObject &first = *manifold.getBody0(), &second = *manifold.getBody1();
  btManifoldPoint point(first.getWorldTransform().invXform(on_first),
                        second.getWorldTransform().invXform(on_second), normal,
                        normal.dot(on_first - on_second));
  point.m_positionWorldOnA = on_first, point.m_positionWorldOnB = on_second;
  point.m_combinedFriction = btManifoldResult::calculateCombinedFriction(&first, &second);
  point.m_combinedRestitution = btManifoldResult::calculateCombinedRestitution(&first, &second);
  btPlaneSpace1(normal, point.m_lateralFrictionDir1, point.m_lateralFrictionDir2);
  return point;
}

void continue_from(const btManifoldPoint& before, btManifoldPoint& point) {
  point.m_appliedImpulse = before.m_appliedImpulse, point.m_prevRHS = before.m_prevRHS;
  point.m_appliedImpulseLateral1 = before.m_appliedImpulseLateral1;
  point.m_appliedImpulseLateral2 = before.m_appliedImpulseLateral2;
  point.m_lifeTime = before.m_lifeTime;
}

}  // namespace loomstone
