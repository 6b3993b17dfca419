#include "core/rigid/sphere_algorithm.h"

#include <algorithm>
#include <array>
#include <new>
#include <utility>
#include <vector>

#include "core/mesh/closest_on_triangle.h"
#include "core/rigid/contacts/sphere_contacts.h"
#include "core/rigid/facets.h"

namespace loomstone {

namespace {

// Contacts in consecutive steps count as the same contact if the squared difference between their
// normals is below this value, which corresponds to 18 degrees.
constexpr btScalar same_contact = 0.1;

// Replaces the contact points of the previous step. A new point starts from the normal impulse of
// the old point whose normal is closest, if the two count as the same contact (same_contact).
void put_points(btPersistentManifold& manifold, const std::vector<SphereContact>& contacts) {
  struct Before {
    btVector3 normal;
    btScalar impulse;
    int life_time;
  };
  Before before[MANIFOLD_CACHE_SIZE];
  const int n_before = manifold.getNumContacts(), n = static_cast<int>(contacts.size());
  for (int k = 0; k < n_before; ++k) {
    const btManifoldPoint& point = manifold.getContactPoint(k);
    before[k] = {point.m_normalWorldOnB, point.m_appliedImpulse, point.m_lifeTime};
  }
  manifold.setNumContacts(n);
  const btCollisionObject &a = *manifold.getBody0(), &b = *manifold.getBody1();
  for (int k = 0; k < n; ++k) {
    const SphereContact& contact = contacts[k];
    btManifoldPoint& point = manifold.getContactPoint(k);
    if (k >= n_before) {
      const btVector3 zero(0, 0, 0);
      point = btManifoldPoint(zero, zero, zero, 0.0);
      point.m_lateralFrictionDir1 = point.m_lateralFrictionDir2 = zero;
      point.m_partId0 = point.m_partId1 = point.m_index0 = point.m_index1 = -1;
    }
    point.m_positionWorldOnA = to_bullet(contact.on_sphere),
    point.m_positionWorldOnB = to_bullet(contact.on_other);
    point.m_localPointA = a.getWorldTransform().invXform(point.m_positionWorldOnA);
    point.m_localPointB = b.getWorldTransform().invXform(point.m_positionWorldOnB);
    point.m_normalWorldOnB = to_bullet(contact.normal);
    point.m_distance1 = contact.gap;
    point.m_combinedFriction = btManifoldResult::calculateCombinedFriction(&a, &b);
    point.m_combinedRestitution = btManifoldResult::calculateCombinedRestitution(&a, &b);
    point.m_appliedImpulse = 0.0, point.m_lifeTime = 0;
    btScalar nearest = same_contact;
    for (int j = 0; j < n_before; ++j) {
      const btScalar distance = before[j].normal.distance2(point.m_normalWorldOnB);
      if (distance >= nearest) continue;
      nearest = distance;
      point.m_appliedImpulse = before[j].impulse, point.m_lifeTime = before[j].life_time + 1;
    }
  }
}

double radius(const btRigidBody& ball) {
  return static_cast<const btSphereShape*>(ball.getCollisionShape())->getRadius();
}

// Adds the contact between two spheres, if there is one. `motion` is the motion of `ball` relative
// to `other` in this step [m]. There is no contact if the gap exceeds both `near` and the length of
// `motion`, or if `motion` closes the gap along the normal but `ball` goes past `other`.
void add_ball(const btRigidBody& ball, const btRigidBody& other, double near, const Vec3& motion,
              std::vector<SphereContact>& contacts) {
  const Vec3 at = from_bullet(ball.getWorldTransform().getOrigin()),
             past = from_bullet(other.getWorldTransform().getOrigin());
  const double reach = radius(ball) + radius(other) + std::max(near, motion.norm());
  if ((at - past).squaredNorm() > reach * reach) return;
  const SphereContact contact = sphere_contact(at, radius(ball), past, radius(other));
  // Add the contact at the start of the motion if the spheres overlap, or if `motion` does not
  // close the gap along the normal, because a third body may still push `ball` against `other`.
  // Otherwise, add the first contact on the path, if there is one.
  if (contact.gap <= 0.0 || -motion.dot(contact.normal) <= contact.gap)
    contacts.push_back(contact);
  else if (const auto ahead = contact_ahead(at, radius(ball), past, radius(other), motion))
    contacts.push_back(*ahead);
}

// Cache of the triangles near a sphere. The search is repeated only when the requested region
// reaches beyond the searched one.
class NearTriangles : btTriangleCallback {
 public:
  // Returns all triangles of the mesh within `reach` of `point`, and possibly more. `point` is
  // given in the axes of the mesh. A search covers an additional distance `room`, so later calls
  // for nearby points need no search.
  const std::vector<std::array<Vec3, 3>>& within(double reach, const btVector3& point, double room,
                                                 const btBvhTriangleMeshShape& mesh) {
    if ((point - centre_).length() + reach > reach_) {
      centre_ = point, reach_ = reach + room;
      triangles_.clear();
      const btVector3 wide = btVector3(1, 1, 1) * reach_;
      mesh.processAllTriangles(this, point - wide, point + wide);
    }
    return triangles_;
  }

 private:
  void processTriangle(btVector3* corners, int, int) override {
    const std::array<Vec3, 3> x = {from_bullet(corners[0]), from_bullet(corners[1]),
                                   from_bullet(corners[2])};
    const Vec3 point = from_bullet(centre_);
    if ((closest_on_triangle(point, x[0], x[1], x[2]).point - point).norm() <= reach_)
      triangles_.push_back(x);
  }

  std::vector<std::array<Vec3, 3>> triangles_;
  btVector3 centre_{0, 0, 0};  // centre of the latest search
  double reach_ = -1.0;        // radius of the latest search [m]; negative before the first search
};

// Collision algorithm for one pair. The first body is a sphere, the second a sphere, a mesh or a
// facet (facets.h).
class SphereAlgorithm : public btCollisionAlgorithm {
 public:
  SphereAlgorithm(const btCollisionAlgorithmConstructionInfo& info, const btCollisionObject* ball,
                  const btCollisionObject* other)
      : btCollisionAlgorithm(info), manifold_(m_dispatcher->getNewManifold(ball, other)) {}
  ~SphereAlgorithm() override { m_dispatcher->releaseManifold(manifold_); }

  void processCollision(const btCollisionObjectWrapper*, const btCollisionObjectWrapper*,
                        const btDispatcherInfo& info, btManifoldResult* result) override {
    result->setPersistentManifold(manifold_);
    const auto& ball = *static_cast<const btRigidBody*>(manifold_->getBody0());
    const auto& other = *static_cast<const btRigidBody*>(manifold_->getBody1());
    const int type = other.getCollisionShape()->getShapeType();
    const bool round = type == SPHERE_SHAPE_PROXYTYPE;
    const btVector3 from =
        ball.getWorldTransform().getOrigin() - other.getWorldTransform().getOrigin();
    btVector3 velocity = ball.getLinearVelocity() -
                         (round ? other.getLinearVelocity() : other.getVelocityInLocalPoint(from));
    velocity += (ball.getGravity() - other.getGravity()) * info.m_timeStep;
    const double near = manifold_->getContactBreakingThreshold();
    const Vec3 motion = from_bullet(velocity * info.m_timeStep);
    contacts_.clear();
    if (round) {
      add_ball(ball, other, near, motion, contacts_);
    } else if (type == TRIANGLE_SHAPE_PROXYTYPE) {
      add_facet(ball, other, near, motion);
    } else {
      add_mesh(ball, other, near, motion);
    }
    if (!contacts_.empty() || manifold_->getNumContacts() > 0) put_points(*manifold_, contacts_);
  }
  btScalar calculateTimeOfImpact(btCollisionObject*, btCollisionObject*, const btDispatcherInfo&,
                                 btManifoldResult*) override {
    return 1.0;  // Bullet calls this only with DISPATCH_CONTINUOUS, which is not used
  }
  void getAllContactManifolds(btManifoldArray& manifolds) override {
    manifolds.push_back(manifold_);
  }

 private:
  void add_mesh(const btRigidBody& ball, const btRigidBody& other, double near,
                const Vec3& motion) {
    const btTransform& pose = other.getWorldTransform();
    const btVector3 local = pose.invXform(ball.getWorldTransform().getOrigin());
    const Vec3 local_motion = from_bullet(pose.getBasis().transpose() * to_bullet(motion));
    const double reach = radius(ball) + std::max(near, motion.norm());
    const auto& mesh = *static_cast<const btBvhTriangleMeshShape*>(other.getCollisionShape());
    found_.find(triangles_.within(reach, local, 0.1 * radius(ball), mesh),
                {from_bullet(local), radius(ball), local_motion}, near, MANIFOLD_CACHE_SIZE,
                contacts_);
    for (SphereContact& contact : contacts_)
      contact = {from_bullet(pose * to_bullet(contact.on_sphere)),
                 from_bullet(pose * to_bullet(contact.on_other)),
                 from_bullet(pose.getBasis() * to_bullet(contact.normal)), contact.gap};
  }

  // Adds the contacts that lie on a facet. The neighbours of the facet are taken into account, so
  // that internal edges of a flat surface have no contacts of their own.
  void add_facet(const btRigidBody& ball, const btRigidBody& other, double near,
                 const Vec3& motion) {
    const auto& facet =
        *static_cast<const FacetSurroundings*>(other.getCollisionShape()->getUserPointer());
    const Vec3 centre = from_bullet(ball.getWorldTransform().getOrigin());
    around_.clear();
    const auto add = [&](const std::array<Index, 3>& corners) {
      around_.emplace_back();
      for (int k = 0; k < 3; ++k) around_.back()[k] = facet.vertices->row(corners[k]).transpose();
    };
    add(facet.corners);
    const auto& [a, b, c] = around_.front();
    const double reach = radius(ball) + std::max(near, motion.norm());
    if ((closest_on_triangle(centre, a, b, c).point - centre).norm() > reach) return;
    for (const auto& corners : facet.others) add(corners);
    found_.find(around_, {centre, radius(ball), motion}, near, MANIFOLD_CACHE_SIZE, contacts_);
    std::erase_if(contacts_, [&](const SphereContact& contact) {
      const auto& [p, q, r] = around_.front();
      const Vec3& point = contact.on_other;
      return (closest_on_triangle(point, p, q, r).point - point).norm() > 1e-9 * radius(ball);
    });
  }

  btPersistentManifold* manifold_;
  NearTriangles triangles_;
  // Scratch memory.
  SphereOnTriangles found_;
  std::vector<std::array<Vec3, 3>> around_;
  std::vector<SphereContact> contacts_;
};

}  // namespace

int SphereAlgorithms::size() { return static_cast<int>(sizeof(SphereAlgorithm)); }

void SphereAlgorithms::enter(btCollisionDispatcher& dispatcher) {
  dispatcher.registerCollisionCreateFunc(SPHERE_SHAPE_PROXYTYPE, SPHERE_SHAPE_PROXYTYPE, &create_);
  for (const int other : {TRIANGLE_MESH_SHAPE_PROXYTYPE, TRIANGLE_SHAPE_PROXYTYPE}) {
    dispatcher.registerCollisionCreateFunc(SPHERE_SHAPE_PROXYTYPE, other, &create_);
    dispatcher.registerCollisionCreateFunc(other, SPHERE_SHAPE_PROXYTYPE, &create_);
  }
}

btCollisionAlgorithm* SphereAlgorithms::Create::CreateCollisionAlgorithm(
    btCollisionAlgorithmConstructionInfo& info, const btCollisionObjectWrapper* first,
    const btCollisionObjectWrapper* second) {
  const bool first_round = first->getCollisionShape()->getShapeType() == SPHERE_SHAPE_PROXYTYPE;
  const btCollisionObject *ball = first->getCollisionObject(),
                          *other = second->getCollisionObject();
  if (!first_round) std::swap(ball, other);
  return new (info.m_dispatcher1->allocateCollisionAlgorithm(size()))
      SphereAlgorithm(info, ball, other);
}

}  // namespace loomstone
