#include "core/rigid/bullet_engine.h"

#include <algorithm>
#include <cmath>

#include "core/rigid/seams.h"
#include "core/rigid/surface_guard.h"

namespace loomstone {

namespace {

btDefaultCollisionConstructionInfo room_for_algorithms() {
  btDefaultCollisionConstructionInfo info;
  info.m_customCollisionAlgorithmMaxElementSize =
      std::max({SphereAlgorithms::size(), HullAlgorithms::size(), PairAlgorithms::size()});
  return info;
}

}  // namespace

void BulletWorld::predictUnconstraintMotion(btScalar step) {
  btDiscreteDynamicsWorld::predictUnconstraintMotion(step);
  for (int i = 0; i < m_nonStaticRigidBodies.size(); ++i)
    if (btRigidBody& body = *m_nonStaticRigidBodies[i]; body.isKinematicObject())
      body.predictIntegratedTransform(step, body.getInterpolationWorldTransform());
}

void BulletWorld::updateAabbs() {
  // Enlargement of the bodies' boxes in the tree [contact distances]. Larger boxes overlap more
  // often but are updated less often.
  constexpr btScalar room = 4.0;
  auto& broadphase = static_cast<btDbvtBroadphase&>(*getBroadphase());
  for (int i = 0; i < m_collisionObjects.size(); ++i) {
    btCollisionObject& object = *m_collisionObjects[i];
    btBroadphaseProxy& proxy = *object.getBroadphaseHandle();
    const btCollisionShape& shape = *object.getCollisionShape();
    if (i == static_cast<int>(margins_.size()))
      margins_.push_back(std::min(shape.getContactBreakingThreshold(gContactBreakingThreshold),
                                  gContactBreakingThreshold));
    const btVector3 wider(margins_[i], margins_[i], margins_[i]);
    btVector3 low, high, end_low, end_high;
    shape.getAabb(object.getWorldTransform(), low, high);
    shape.getAabb(object.getInterpolationWorldTransform(), end_low,
                  end_high);  // at the end of the step
    low.setMin(end_low), high.setMax(end_high);
    low -= wider, high += wider;
    if (object.isStaticOrKinematicObject()) {
      broadphase.setAabb(&proxy, low, high, getDispatcher());
      continue;
    }
    const auto below = [](const btVector3& a, const btVector3& b) {
      return a.x() <= b.x() && a.y() <= b.y() && a.z() <= b.z();
    };
    const btVector3 loose = wider * (3.0 * room);
    const bool inside = below(proxy.m_aabbMin, low) && below(high, proxy.m_aabbMax);
    if (inside && below(low - loose, proxy.m_aabbMin) && below(proxy.m_aabbMax, high + loose))
      continue;
    broadphase.setAabbForceUpdate(&proxy, low - room * wider, high + room * wider, getDispatcher());
  }
}

// Sets the coefficient of restitution of a contact point, given that of the two bodies
// (`restitution`). Bullet multiplies the coefficient of the point by an approach speed that
// includes the kicks. The coefficient is therefore the speed of the rebound (see Kicks) divided by
// this approach speed, or 0 if the bodies do not bounce. If they bounce, sets a positive gap to 0.
void BulletWorld::set_restitution(const btPersistentManifold& manifold, double restitution,
                                  const btContactSolverInfo& info, btManifoldPoint& point) const {
  const auto& a = static_cast<const btRigidBody&>(*manifold.getBody0());
  const auto& b = static_cast<const btRigidBody&>(*manifold.getBody1());
  const btVector3 arm_a = point.m_positionWorldOnA - a.getWorldTransform().getOrigin(),
                  arm_b = point.m_positionWorldOnB - b.getWorldTransform().getOrigin();
  const btVector3& normal = point.m_normalWorldOnB;
  const auto of = [](const std::vector<Kick>& kicks, const btRigidBody& body,
                     const btVector3& arm) {
    const auto i = static_cast<std::size_t>(body.getUserIndex());  // beyond the end for obstacles
    return i < kicks.size() ? kicks[i].linear + kicks[i].angular.cross(arm) : btVector3(0, 0, 0);
  };
  const auto approach = [&](const std::vector<Kick>& kicks) {
    return -normal.dot(of(kicks, a, arm_a) - of(kicks, b, arm_b));
  };
  const btScalar speed =
      -normal.dot(a.getVelocityInLocalPoint(arm_a) - b.getVelocityInLocalPoint(arm_b));
  const btScalar half = approach(kicks_.half), before = speed - approach(kicks_.whole) - half;
  const bool meets = speed > 0.0 && point.getDistance() <= speed * info.m_timeStep;
  const bool bounces = meets && before > info.m_restitutionVelocityThreshold;
  const btScalar after = std::max(restitution * before - half, 0.0);
  point.m_combinedRestitution = bounces ? after / speed : 0.0;
  if (bounces && point.getDistance() > 0.0) point.setDistance(0.0);
}

void BulletWorld::solveConstraints(btContactSolverInfo& info) {
  remove_contacts_behind_others(*getDispatcher(), info.m_timeStep);
  before_.clear();
  for (int i = 0; i < m_nonStaticRigidBodies.size(); ++i)
    before_.push_back(m_nonStaticRigidBodies[i]->getWorldTransform().getOrigin());
  for (int m = 0; m < getDispatcher()->getNumManifolds(); ++m) {
    btPersistentManifold& manifold = *getDispatcher()->getManifoldByIndexInternal(m);
    const btScalar restitution =
        btManifoldResult::calculateCombinedRestitution(manifold.getBody0(), manifold.getBody1());
    if (restitution == 0.0) continue;
    for (int k = 0; k < manifold.getNumContacts(); ++k)
      set_restitution(manifold, restitution, info, manifold.getContactPoint(k));
  }
  btDiscreteDynamicsWorld::solveConstraints(info);
}

void BulletWorld::integrateTransforms(btScalar step) {
  btDiscreteDynamicsWorld::integrateTransforms(step);
  for (int i = 0; i < m_nonStaticRigidBodies.size(); ++i)
    if (!m_nonStaticRigidBodies[i]->isStaticOrKinematicObject())
      stop_at_surfaces(*getBroadphase(), before_[i], *m_nonStaticRigidBodies[i]);
}

BulletEngine::BulletEngine(const Vec3& gravity, int iterations)
    : configuration(room_for_algorithms()) {
  configuration.setConvexConvexMultipointIterations(4, 4);
  configuration.setPlaneConvexMultipointIterations(4, 4);
  btContactSolverInfo& info = world.getSolverInfo();
  info.m_numIterations = iterations;
  info.m_solverMode |= SOLVER_USE_2_FRICTION_DIRECTIONS;
  info.m_warmstartingFactor = 1.0;  // Bullet's default is 0.85
  spheres.enter(dispatcher);
  hulls.enter(dispatcher, configuration);
  pairs.enter(dispatcher, configuration);
  world.getDispatchInfo().m_enableSatConvex = true;  // separating-axis test for polyhedra
  broadphase.m_cupdates = 100;  // percentage of pairs that each step checks for separation
  info.m_splitImpulsePenetrationThreshold = 0.0;  // resolving penetration adds no velocity
  world.setGravity(to_bullet(gravity));
}

BulletEngine::~BulletEngine() {
  for (auto& body : bodies) world.removeRigidBody(body.get());
}

btRigidBody& BulletEngine::add(double mass, const Vec3& inertia, btCollisionShape& shape,
                               double friction, double restitution) {
  btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, &shape, to_bullet(inertia));
  // Bullet multiplies the m_friction of the two bodies in contact, so the friction coefficient of
  // the contact is sqrt(mu_a mu_b).
  info.m_friction = std::sqrt(friction);
  info.m_restitution = restitution;
  bodies.push_back(std::make_unique<btRigidBody>(info));
  btRigidBody& body = *bodies.back();
  body.setUserIndex(static_cast<int>(bodies.size()) - 1);
  body.setActivationState(DISABLE_DEACTIVATION);
  return body;
}

btRigidBody& BulletEngine::add_obstacle(btCollisionShape& shape, double friction) {
  btRigidBody& body = add(0.0, Vec3::Zero(), shape, friction, 1.0);
  body.setCollisionFlags((body.getCollisionFlags() & ~btCollisionObject::CF_STATIC_OBJECT) |
                         btCollisionObject::CF_KINEMATIC_OBJECT);
  return body;
}

void set_pose(btRigidBody& body, const btTransform& pose) {
  body.setWorldTransform(pose);
  body.setInterpolationWorldTransform(pose);
  body.updateInertiaTensor();
}

void set_velocity(btRigidBody& body, const Vec3& velocity, const Vec3& angular_velocity) {
  body.setLinearVelocity(to_bullet(velocity));
  body.setAngularVelocity(to_bullet(angular_velocity));
  body.setInterpolationLinearVelocity(to_bullet(velocity));
  body.setInterpolationAngularVelocity(to_bullet(angular_velocity));
}

}  // namespace loomstone
