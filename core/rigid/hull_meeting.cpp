#include "core/rigid/hull_meeting.h"

#include <algorithm>
#include <new>
#include <utility>
#include <vector>

#include "core/rigid/hull_contacts.h"

namespace loomstone {

namespace {

using Corners = std::array<Vec3, 3>;

const Polyhedron* polyhedron_of(const btCollisionObjectWrapper& object) {
  return static_cast<const Polyhedron*>(object.getCollisionShape()->getUserPointer());
}

// Triangles of a mesh that meet a box, in the axes of the hull.
class Collect : public btTriangleCallback {
 public:
  Collect(const btTransform& to_hull, const btVector3& low, const btVector3& high, std::vector<Corners>& triangles)
      : to_hull_(to_hull), low_(low), high_(high), triangles_(triangles) {}
  void processTriangle(btVector3* corners, int, int) override {
    if (!TestTriangleAgainstAabb2(corners, low_, high_)) return;
    Corners x;
    for (int k = 0; k < 3; ++k) x[k] = from_bullet(to_hull_ * corners[k]);
    triangles_.push_back(x);
  }

 private:
  btTransform to_hull_;
  btVector3 low_, high_;
  std::vector<Corners>& triangles_;
};

// Of a hull, that may be part of a body, and a mesh or a triangle.
class HullMeeting : public btCollisionAlgorithm {
 public:
  HullMeeting(const btCollisionAlgorithmConstructionInfo& info, const btCollisionObjectWrapper* first,
              const btCollisionObjectWrapper* second)
      : btCollisionAlgorithm(info), shared_(info.m_manifold != nullptr),
        manifold_(shared_ ? info.m_manifold
                          : m_dispatcher->getNewManifold(first->getCollisionObject(), second->getCollisionObject())) {}
  ~HullMeeting() override {
    if (!shared_) m_dispatcher->releaseManifold(manifold_);
  }

  void processCollision(const btCollisionObjectWrapper* first, const btCollisionObjectWrapper* second,
                        const btDispatcherInfo&, btManifoldResult* result) override {
    if (!shared_) result->setPersistentManifold(manifold_);
    const bool hull_first = polyhedron_of(*first) != nullptr;
    const btCollisionObjectWrapper &hull = hull_first ? *first : *second, &other = hull_first ? *second : *first;
    const btTransform& pose = hull.getWorldTransform();
    const double near = manifold_->getContactBreakingThreshold();
    triangles_.clear();
    collect(hull, other, near);
    contacts_of_.find(*polyhedron_of(hull), triangles_, near, contacts_);
    // The result takes points on its second body, normals away from it.
    const bool towards_first = result->getBody0Wrap()->getCollisionObject() == hull.getCollisionObject();
    for (const HullContact& contact : contacts_) {
      const btVector3 normal = pose.getBasis() * to_bullet(contact.normal), point = pose * to_bullet(contact.point);
      if (towards_first) {
        result->addContactPoint(normal, point, contact.gap);
      } else {
        result->addContactPoint(-normal, point + contact.gap * normal, contact.gap);
      }
    }
    if (!shared_) result->refreshContactPoints();
  }
  btScalar calculateTimeOfImpact(btCollisionObject*, btCollisionObject*, const btDispatcherInfo&, btManifoldResult*) override {
    return 1.0;  // Bullet asks no one
  }
  void getAllContactManifolds(btManifoldArray& manifolds) override {
    if (!shared_) manifolds.push_back(manifold_);
  }

 private:
  void collect(const btCollisionObjectWrapper& hull, const btCollisionObjectWrapper& other, double near) {
    const btTransform to_hull = hull.getWorldTransform().inverseTimes(other.getWorldTransform());
    btVector3 low, high;
    hull.getCollisionShape()->getAabb(to_hull.inverse(), low, high);
    const btVector3 wider(near, near, near);
    Collect found(to_hull, low - wider, high + wider, triangles_);
    if (other.getCollisionShape()->getShapeType() == TRIANGLE_SHAPE_PROXYTYPE) {
      btVector3 corners[3];
      std::copy_n(static_cast<const btTriangleShape*>(other.getCollisionShape())->m_vertices1, 3, corners);
      found.processTriangle(corners, 0, 0);
    } else {
      static_cast<const btConcaveShape*>(other.getCollisionShape())->processAllTriangles(&found, low - wider, high + wider);
    }
  }

  bool shared_;  // with the other parts of a body
  btPersistentManifold* manifold_;
  HullOnTriangles contacts_of_;  // these three are kept for their memory alone
  std::vector<Corners> triangles_;
  std::vector<HullContact> contacts_;
};

}  // namespace

int HullMeetings::size() { return static_cast<int>(sizeof(HullMeeting)); }

void HullMeetings::enter(btCollisionDispatcher& dispatcher, btCollisionConfiguration& configuration) {
  std::size_t k = 0;
  for (const int hull : {CONVEX_HULL_SHAPE_PROXYTYPE, BOX_SHAPE_PROXYTYPE})
    for (const int other : {TRIANGLE_MESH_SHAPE_PROXYTYPE, TRIANGLE_SHAPE_PROXYTYPE})
      for (const auto& [first, second] : {std::pair(hull, other), std::pair(other, hull)}) {
        create_[k].others = configuration.getCollisionAlgorithmCreateFunc(first, second);
        dispatcher.registerCollisionCreateFunc(first, second, &create_[k++]);
      }
}

btCollisionAlgorithm* HullMeetings::Create::CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                                     const btCollisionObjectWrapper* first,
                                                                     const btCollisionObjectWrapper* second) {
  if (!polyhedron_of(*first) && !polyhedron_of(*second)) return others->CreateCollisionAlgorithm(info, first, second);
  return new (info.m_dispatcher1->allocateCollisionAlgorithm(size())) HullMeeting(info, first, second);
}

}  // namespace loomstone
