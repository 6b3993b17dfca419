#include "core/rigid/seams.h"

#include <algorithm>
#include <functional>
#include <vector>

namespace loomstone {

namespace {

// A contact between a sphere and another object. The sphere is the first body of the manifold.
struct BallContact {
  btPersistentManifold* manifold;
  int point;
  btVector3 normal, on_other;  // the normal points to the sphere
  btScalar gap;                // 0 for overlaps [m]
  btVector3 other_motion;      // of the other object at the contact, in a step without contacts [m]
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
bool is_obstacle(const btCollisionObject& object) { return object.isStaticOrKinematicObject(); }

// Returns the motion of a body at a point in a step without contacts [m].
btVector3 motion_at(const btRigidBody& body, const btVector3& point, btScalar step) {
  const btVector3 arm = point - body.getWorldTransform().getOrigin();
  return step * (body.getVelocityInLocalPoint(arm) + step * body.getGravity());
}

BallContact contact_of(btPersistentManifold& manifold, int k, btScalar step) {
  const btManifoldPoint& point = manifold.getContactPoint(k);
  const btVector3& on_other = point.getPositionWorldOnB();
  return {&manifold,
          k,
          point.m_normalWorldOnB,
          on_other,
          std::max(point.getDistance(), btScalar(0)),
          motion_at(second(manifold), on_other, step)};
}

// Returns the share of the step [1] after which the gap is closed if the sphere moves by `motion`
// [m] in the step, or 2 if the gap is still open at the end of the step.
btScalar closing_time(const BallContact& contact, const btVector3& motion) {
  const btScalar closed = -contact.normal.dot(motion - contact.other_motion);
  return closed > contact.gap ? contact.gap / closed : 2.0;
}

// Path of a sphere whose motion in the step, without contacts, is `whole` [m]. The contacts in
// `earlier` block a part of this motion. `motion` is the rest, which the sphere makes in the step
// [m]. `direction` (of any length) is the direction in which it continues after the step. Only
// contacts with obstacles block motion, because bodies may give way, and only those of other pairs
// than that of `contact`.
struct Path {
  Path(const std::vector<BallContact>& earlier, const BallContact& contact, const btVector3& whole)
      : motion(whole), direction(whole) {
    for (int pass = 0; pass < 2; ++pass)
      for (const BallContact& other : earlier) {
        if (other.manifold == contact.manifold || !is_obstacle(second(*other.manifold))) continue;
        block(other, other.gap, motion);
        block(other, 0.0, direction);
      }
  }
  static void block(const BallContact& by, btScalar gap, btVector3& motion) {
    const btScalar blocked = -by.normal.dot(motion - by.other_motion) - gap;
    if (blocked > 0.0) motion += blocked * by.normal;
  }

  btVector3 motion, direction;
};

// Returns the distance [m] of a point from the segment that begins at `from` and ends at
// from + end * direction.
btScalar distance_from_ray(const btVector3& point, const btVector3& from,
                           const btVector3& direction, btScalar end) {
  const btScalar length2 = direction.length2();
  const btScalar share = length2 > 0.0 ? (point - from).dot(direction) / length2 : 0.0;
  return (from + std::clamp(share, btScalar(0), end) * direction - point).length();
}

// Returns whether a sphere on `path` goes past the other object of `contact`, which its motion
// without contacts, `whole`, would meet. It does if its centre stays at least a radius away from
// the contact point on the object, within the tolerance of flush surfaces. Other points of the
// object need no test if path.motion and `whole` differ little. The path is continued beyond the
// step, because a short motion enters an object only slightly. Returns false if path.motion and
// `whole` are equal or differ by more than half the radius, or if the sphere stops after the step.
bool passes(const BallContact& contact, const btVector3& whole, const Path& path) {
  const btRigidBody& sphere = first(*contact.manifold);
  const btVector3& centre = sphere.getWorldTransform().getOrigin();
  const btScalar radius =
      static_cast<const btSphereShape&>(*sphere.getCollisionShape()).getRadius();
  const btScalar blocked = (path.motion - whole).length();
  const btVector3 motion = path.motion - contact.other_motion,
                  direction = path.direction - contact.other_motion;
  if (blocked == 0.0 || blocked > 0.5 * radius || direction.length() < 1e-6 * whole.length())
    return false;
  const btScalar least = radius - flush_share * contact.manifold->getContactBreakingThreshold();
  return distance_from_ray(contact.on_other, centre, motion, 1.0) >= least &&
         distance_from_ray(contact.on_other, centre + motion, direction, BT_LARGE_FLOAT) >= least;
}

// Removes contacts of a sphere with obstacles. A contact is removed if the motion of the sphere
// without contacts would close it, but passes() is true for the path that earlier contacts leave.
// `contacts` contains all contacts of the sphere.
void remove_passed(std::vector<BallContact> contacts, btScalar step) {
  const btRigidBody& sphere = first(*contacts.front().manifold);
  const btVector3 motion = motion_at(sphere, sphere.getWorldTransform().getOrigin(), step);
  std::ranges::stable_sort(contacts, {}, [&](const auto& c) { return closing_time(c, motion); });
  std::vector<BallContact> kept, removed;
  for (const BallContact& contact : contacts) {
    const bool closes = closing_time(contact, motion) <= 1.0;
    const bool out = closes && is_obstacle(second(*contact.manifold)) &&
                     passes(contact, motion, Path(kept, contact, motion));
    if (closes) (out ? removed : kept).push_back(contact);
  }
  // Points are removed in descending order of their index, because Bullet moves the last point of a
  // manifold to the place of the removed one.
  std::ranges::stable_sort(removed, std::greater<>(), &BallContact::point);
  for (const BallContact& contact : removed) contact.manifold->removeContactPoint(contact.point);
}

}  // namespace

void remove_contacts_behind_others(btDispatcher& dispatcher, btScalar step) {
  const int n_manifolds = dispatcher.getNumManifolds();
  const auto each_of_spheres = [&](const auto& visit) {
    for (int m = 0; m < n_manifolds; ++m) {
      btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(m);
      if (manifold.getNumContacts() > 0 && is_sphere(first(manifold)) &&
          !is_obstacle(first(manifold)))
        visit(manifold, first(manifold).getUserIndex());
    }
  };
  std::vector<int> n_obstacles;  // with which each ball has contacts
  each_of_spheres([&](const btPersistentManifold& manifold, int ball) {
    if (ball >= static_cast<int>(n_obstacles.size())) n_obstacles.resize(ball + 1, 0);
    n_obstacles[ball] += is_obstacle(second(manifold));
  });
  std::vector<std::vector<BallContact>> contacts(n_obstacles.size());
  each_of_spheres([&](btPersistentManifold& manifold, int ball) {
    if (n_obstacles[ball] < 2) return;
    for (int k = 0; k < manifold.getNumContacts(); ++k)
      contacts[ball].push_back(contact_of(manifold, k, step));
  });
  for (const std::vector<BallContact>& of_ball : contacts)
    if (!of_ball.empty()) remove_passed(of_ball, step);
}

}  // namespace loomstone
