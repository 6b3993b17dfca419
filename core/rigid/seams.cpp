#include "core/rigid/seams.h"

#include <algorithm>
#include <functional>
#include <vector>

namespace loomstone {

namespace {

// A contact of a sphere, which is the first body of its manifold.
struct Met {
  btPersistentManifold* manifold;
  int point;
  btVector3 normal, on_other;  // the normal points to the sphere
  btScalar gap;                // 0 for overlaps [m]
  btVector3 other_motion;      // of the other object at the contact [m]
};

const btRigidBody& first(const btPersistentManifold& manifold) {
  return static_cast<const btRigidBody&>(*manifold.getBody0());
}
const btRigidBody& second(const btPersistentManifold& manifold) {
  return static_cast<const btRigidBody&>(*manifold.getBody1());
}

bool is_sphere(const btCollisionObject& object) {
  return object.getCollisionShape()->getShapeType() == SPHERE_SHAPE_PROXYTYPE;
}

// Returns the motion of a body at a point in a step without contacts [m].
btVector3 motion_at(const btRigidBody& body, const btVector3& point, btScalar step) {
  const btVector3 arm = point - body.getWorldTransform().getOrigin();
  return step * (body.getVelocityInLocalPoint(arm) + step * body.getGravity());
}

Met met_at(btPersistentManifold& manifold, int k, btScalar step) {
  const btManifoldPoint& point = manifold.getContactPoint(k);
  const btVector3& on_other = point.getPositionWorldOnB();
  return {&manifold,
          k,
          point.m_normalWorldOnB,
          on_other,
          std::max(point.getDistance(), btScalar(0)),
          motion_at(second(manifold), on_other, step)};
}

// Returns the share of the step after which a motion of the sphere closes the gap, or 2 if it does
// not.
btScalar closing_time(const Met& met, const btVector3& motion) {
  const btScalar closed = -met.normal.dot(motion - met.other_motion);
  return closed > met.gap ? met.gap / closed : 2.0;
}

// Returns the motion of a sphere without the parts that contacts with other obstacles block which
// come before `last`. Bodies may give way, so their contacts do not count.
btVector3 motion_left(const std::vector<Met>& contacts, const Met& last, const btVector3& motion) {
  const btScalar end = closing_time(last, motion);
  btVector3 left = motion;
  for (int pass = 0; pass < 2; ++pass)
    for (const Met& met : contacts) {
      if (met.manifold == last.manifold || !second(*met.manifold).isStaticOrKinematicObject() ||
          closing_time(met, motion) >= end)
        continue;
      const btScalar blocked = -met.normal.dot(left - met.other_motion) - met.gap;
      if (blocked > 0.0) left += blocked * met.normal;
    }
  return left;
}

btScalar distance_from_path(const btVector3& point, const btVector3& from, const btVector3& path) {
  const btScalar length2 = path.length2();
  const btScalar share = length2 > 0.0 ? (point - from).dot(path) / length2 : 0.0;
  return (from + std::clamp(share, btScalar(0), btScalar(1)) * path - point).length();
}

// Removes contacts of a sphere. `contacts` contains all that it has.
void remove_unreached(const std::vector<Met>& contacts, btScalar step) {
  const btRigidBody& sphere = first(*contacts.front().manifold);
  const btVector3 centre = sphere.getWorldTransform().getOrigin(),
                  motion = motion_at(sphere, centre, step);
  const btScalar radius =
      static_cast<const btSphereShape&>(*sphere.getCollisionShape()).getRadius();
  std::vector<Met> removed;
  for (const Met& met : contacts) {
    if (is_sphere(second(*met.manifold)) || closing_time(met, motion) > 1.0) continue;
    const btVector3 left = motion_left(contacts, met, motion);
    const btScalar least = radius - flush_share * met.manifold->getContactBreakingThreshold();
    if (left != motion &&
        distance_from_path(met.on_other, centre, left - met.other_motion) >= least)
      removed.push_back(met);
  }
  // In descending order, because Bullet moves the last point of a manifold to the removed place.
  std::ranges::stable_sort(removed, std::greater<>(), &Met::point);
  for (const Met& met : removed) met.manifold->removeContactPoint(met.point);
}

}  // namespace

void remove_contacts_behind_others(btDispatcher& dispatcher, btScalar step) {
  const int n_manifolds = dispatcher.getNumManifolds();
  const auto each_of_spheres = [&](const auto& visit) {
    for (int m = 0; m < n_manifolds; ++m) {
      btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(m);
      if (manifold.getNumContacts() > 0 && is_sphere(first(manifold)) &&
          !first(manifold).isStaticOrKinematicObject())
        visit(manifold, first(manifold).getUserIndex());
    }
  };
  // Spheres with contacts with an obstacle and another object.
  std::vector<int> n_objects, n_obstacles;
  each_of_spheres([&](const btPersistentManifold& manifold, int ball) {
    if (ball >= static_cast<int>(n_objects.size()))
      n_objects.resize(ball + 1, 0), n_obstacles.resize(ball + 1, 0);
    ++n_objects[ball], n_obstacles[ball] += second(manifold).isStaticOrKinematicObject();
  });
  std::vector<std::vector<Met>> contacts(n_objects.size());
  each_of_spheres([&](btPersistentManifold& manifold, int ball) {
    if (n_objects[ball] < 2 || n_obstacles[ball] == 0) return;
    for (int k = 0; k < manifold.getNumContacts(); ++k)
      contacts[ball].push_back(met_at(manifold, k, step));
  });
  for (const std::vector<Met>& of_sphere : contacts)
    if (!of_sphere.empty()) remove_unreached(of_sphere, step);
}

}  // namespace loomstone
