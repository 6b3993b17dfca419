#include "core/rigid/bullet_engine.h"

#include <algorithm>
#include <cmath>

namespace loomstone {

namespace {

btDefaultCollisionConstructionInfo room_for_algorithms() {
  btDefaultCollisionConstructionInfo info;
  info.m_customCollisionAlgorithmMaxElementSize =
      std::max(SphereAlgorithms::size(), HullAlgorithms::size());
  return info;
}

}  // namespace

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
                  end_high);  // obstacles keep their start pose during a step
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

// Returns the kick [m/s] of the point of the object at `place`. Obstacles have none.
btVector3 BulletWorld::kick_at(const btCollisionObject& object, const btVector3& place) const {
  const auto body = static_cast<std::size_t>(object.getUserIndex());
  if (body >= kicks_.size()) return btVector3(0, 0, 0);
  return kicks_[body].linear +
         kicks_[body].angular.cross(place - object.getWorldTransform().getOrigin());
}

// Bullet multiplies the restitution coefficient of a contact point by its approach speed, which
// includes the kicks. This function first scales the coefficient, so that the product is that of
// the approach speed without kicks.
void BulletWorld::solveConstraints(btContactSolverInfo& info) {
  for (int m = 0; m < getDispatcher()->getNumManifolds(); ++m) {
    btPersistentManifold& manifold = *getDispatcher()->getManifoldByIndexInternal(m);
    const auto& a = static_cast<const btRigidBody&>(*manifold.getBody0());
    const auto& b = static_cast<const btRigidBody&>(*manifold.getBody1());
    const btScalar restitution = btManifoldResult::calculateCombinedRestitution(&a, &b);
    if (restitution == 0.0) continue;
    for (int k = 0; k < manifold.getNumContacts(); ++k) {
      btManifoldPoint& point = manifold.getContactPoint(k);
      const btVector3 &on_a = point.m_positionWorldOnA, &on_b = point.m_positionWorldOnB;
      const btVector3 velocity =
          a.getVelocityInLocalPoint(on_a - a.getWorldTransform().getOrigin()) -
          b.getVelocityInLocalPoint(on_b - b.getWorldTransform().getOrigin());
      const btVector3 kick = kick_at(a, on_a) - kick_at(b, on_b);
      const btScalar speed = -point.m_normalWorldOnB.dot(velocity);
      const btScalar before = -point.m_normalWorldOnB.dot(velocity - kick);
      const bool bounces = speed > 0.0 && before > info.m_restitutionVelocityThreshold;
      point.m_combinedRestitution = bounces ? restitution * (before / speed) : 0.0;
    }
  }
  btDiscreteDynamicsWorld::solveConstraints(info);
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
  world.getDispatchInfo().m_enableSatConvex = true;  // separating-axis test for polyhedra
  broadphase.m_cupdates = 100;  // percentage of pairs that each step checks for separation
  world.getDispatchInfo().m_allowedCcdPenetration = 0.0;  // Bullet's default is 4 cm
  info.m_splitImpulsePenetrationThreshold = 0.0;          // resolving penetration adds no velocity
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
