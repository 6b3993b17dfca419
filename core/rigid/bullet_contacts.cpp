#include "core/rigid/bullet_contacts.h"

#include <algorithm>
#include <vector>

#include "core/rigid/sphere_contacts.h"

namespace loomstone {

namespace {

struct TellTriangles : btTriangleCallback {
  SphereOnTriangles& found;
  explicit TellTriangles(SphereOnTriangles& to) : found(to) {}
  void processTriangle(btVector3* corners, int, int) override {
    found.add(from_bullet(corners[0]), from_bullet(corners[1]), from_bullet(corners[2]));
  }
};

// In place of the points that Bullet has found. A new point goes on from the impulse of the old one whose normal is nearest.
void put_points(btPersistentManifold& manifold, bool sphere_first, const std::vector<SphereContact>& contacts) {
  constexpr btScalar same = 0.1;  // squared distance of normals: 18 degrees
  btManifoldPoint old[MANIFOLD_CACHE_SIZE];
  const int n_old = manifold.getNumContacts();
  for (int k = 0; k < n_old; ++k) old[k] = manifold.getContactPoint(k);
  manifold.clearManifold();
  const btCollisionObject &a = *manifold.getBody0(), &b = *manifold.getBody1();
  for (const SphereContact& contact : contacts) {
    const btVector3 on_a = to_bullet(sphere_first ? contact.on_sphere : contact.on_other);
    const btVector3 on_b = to_bullet(sphere_first ? contact.on_other : contact.on_sphere);
    const btVector3 normal = to_bullet(sphere_first ? contact.normal : Vec3(-contact.normal));
    btManifoldPoint point(a.getWorldTransform().invXform(on_a), b.getWorldTransform().invXform(on_b), normal, contact.gap);
    point.m_positionWorldOnA = on_a, point.m_positionWorldOnB = on_b;
    point.m_combinedFriction = btManifoldResult::calculateCombinedFriction(&a, &b);
    point.m_combinedRestitution = btManifoldResult::calculateCombinedRestitution(&a, &b);
    const auto from = [&](const btManifoldPoint& p) { return p.m_normalWorldOnB.distance2(normal); };
    btManifoldPoint* const before = std::min_element(old, old + n_old, [&](const auto& p, const auto& q) { return from(p) < from(q); });
    if (before != old + n_old && from(*before) < same) {
      point.m_appliedImpulse = before->m_appliedImpulse;
      point.m_lifeTime = before->m_lifeTime + 1;
    }
    manifold.addManifoldPoint(point);
  }
}

double radius(const btRigidBody& ball) { return static_cast<const btSphereShape*>(ball.getCollisionShape())->getRadius(); }

// `near`: gap up to which they touch; `motion`: of the ball past the other in this step, none for balls that bounce.
std::vector<SphereContact> with_ball(const btRigidBody& ball, const btRigidBody& other, double near, const Vec3& motion) {
  const Vec3 at = from_bullet(ball.getWorldTransform().getOrigin()), past = from_bullet(other.getWorldTransform().getOrigin());
  const SphereContact contact = sphere_contact(at, radius(ball), past, radius(other));
  if (contact.gap <= near) return {contact};
  if (contact.gap > motion.norm()) return {};
  // What passes round the other would be held up by the plane that touches it.
  const bool meets = least_gap(at, radius(ball), past, radius(other), motion) <= near;
  if (!meets && -motion.dot(contact.normal) > contact.gap) return {};
  return {contact};
}

std::vector<SphereContact> with_mesh(const btRigidBody& ball, const btRigidBody& other, double near, const Vec3& motion) {
  const btTransform& pose = other.getWorldTransform();
  const btVector3 local = pose.invXform(ball.getWorldTransform().getOrigin());
  const double reach = std::max(near, motion.norm());
  SphereOnTriangles found(from_bullet(local), radius(ball), reach);
  const btVector3 wide = btVector3(1, 1, 1) * (radius(ball) + reach);
  TellTriangles tell(found);
  static_cast<const btBvhTriangleMeshShape*>(other.getCollisionShape())->processAllTriangles(&tell, local - wide, local + wide);
  std::vector<SphereContact> contacts = found.contacts(MANIFOLD_CACHE_SIZE);
  for (SphereContact& contact : contacts)
    contact = {from_bullet(pose * to_bullet(contact.on_sphere)), from_bullet(pose * to_bullet(contact.on_other)),
               from_bullet(pose.getBasis() * to_bullet(contact.normal)), contact.gap};
  return contacts;
}

// Spheres meet one another and meshes by what sphere_contacts.h finds, where Bullet makes contacts of spheres only once they
// overlap, several for each pair, and holds them up at edges within a plane. Up to where the speeds lead in this step, unless
// they bounce: a contact ahead lets bodies come just as near as touching, so that they need not overlap first.
bool meet_as_spheres(btBroadphasePair& pair, btCollisionDispatcher& dispatcher, btScalar step) {
  auto* const first = static_cast<btRigidBody*>(pair.m_pProxy0->m_clientObject);
  auto* const second = static_cast<btRigidBody*>(pair.m_pProxy1->m_clientObject);
  const auto is = [](const btRigidBody* body, int type) { return body->getCollisionShape()->getShapeType() == type; };
  const bool first_round = is(first, SPHERE_SHAPE_PROXYTYPE), second_round = is(second, SPHERE_SHAPE_PROXYTYPE);
  const btRigidBody &ball = first_round ? *first : *second, &other = first_round ? *second : *first;
  const bool round = first_round && second_round;
  if (!round && !((first_round || second_round) && is(&other, TRIANGLE_MESH_SHAPE_PROXYTYPE))) return false;
  if (!dispatcher.needsCollision(first, second)) return true;
  if (!pair.m_algorithm) {  // Bullet's, which owns the manifold
    const btCollisionObjectWrapper one(nullptr, first->getCollisionShape(), first, first->getWorldTransform(), -1, -1);
    const btCollisionObjectWrapper two(nullptr, second->getCollisionShape(), second, second->getWorldTransform(), -1, -1);
    pair.m_algorithm = dispatcher.findAlgorithm(&one, &two, nullptr, BT_CONTACT_POINT_ALGORITHMS);
  }
  btManifoldArray manifolds;
  pair.m_algorithm->getAllContactManifolds(manifolds);
  btPersistentManifold& manifold = *manifolds[0];

  const btVector3 from = ball.getWorldTransform().getOrigin() - other.getWorldTransform().getOrigin();
  btVector3 velocity = ball.getLinearVelocity() - (round ? other.getLinearVelocity() : other.getVelocityInLocalPoint(from));
  velocity += (ball.getGravity() - other.getGravity()) * step;
  double near = manifold.getContactBreakingThreshold();
  if (btManifoldResult::calculateCombinedRestitution(first, second) > 0.0) {
    velocity.setZero();
    if (manifold.getNumContacts() == 0) near = 0.0;  // thrown back where they touch, no sooner
  }
  const Vec3 motion = from_bullet(velocity * step);
  put_points(manifold, manifold.getBody0() == &ball, round ? with_ball(ball, other, near, motion) : with_mesh(ball, other, near, motion));
  return true;
}

}  // namespace

void meet(btBroadphasePair& pair, btCollisionDispatcher& dispatcher, const btDispatcherInfo& info) {
  if (meet_as_spheres(pair, dispatcher, info.m_timeStep)) return;
  const auto shape = [](const btBroadphaseProxy* proxy) {
    return static_cast<const btCollisionObject*>(proxy->m_clientObject)->getCollisionShape();
  };
  btDispatcherInfo chosen = info;
  const auto flat = [](const btCollisionShape* s) { return s->isConcave() || s->getShapeType() == TRIANGLE_SHAPE_PROXYTYPE; };
  chosen.m_enableSatConvex = !flat(shape(pair.m_pProxy0)) && !flat(shape(pair.m_pProxy1));
  btCollisionDispatcher::defaultNearCallback(pair, dispatcher, chosen);
}

}  // namespace loomstone
