#include "core/rigid/hull_algorithm.h"

#include <algorithm>
#include <new>
#include <utility>

#include "core/rigid/contacts/crossing.h"
#include "core/rigid/contacts/hull_contacts.h"
#include "core/rigid/facets.h"
#include "core/rigid/manifold_point.h"
#include "core/rigid/pair_algorithm.h"
#include "core/rigid/seams.h"
#include "core/rigid/step_motion.h"

namespace loomstone {

namespace {

using Corners = HullOnTriangles::Corners;

constexpr std::size_t most_planes = 4;  // largest number of contact planes of a hull and a mesh
// Contact planes of consecutive steps count as the same plane if the cosine of the angle between
// their normals is at least this value.
constexpr btScalar still_same_plane = 0.9;

bool is_triangle(const btCollisionObjectWrapper& object) {
  return object.getCollisionShape()->getShapeType() == TRIANGLE_SHAPE_PROXYTYPE;
}

const ConvexPolyhedron* polyhedron_of(const btCollisionObjectWrapper& object) {
  return is_triangle(object)
             ? nullptr
             : static_cast<const ConvexPolyhedron*>(object.getCollisionShape()->getUserPointer());
}

// Collects all mesh triangles whose bounding boxes intersect a given box, and transforms them to
// the axes of the hull.
class Collect : public btTriangleCallback {
 public:
  Collect(const btTransform& to_hull, const btVector3& low, const btVector3& high,
          std::vector<Corners>& triangles)
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

// Collision algorithm for a hull against a mesh or a triangle. The hull may be part of a body. A
// fast hull gets contacts before it touches the other object, so that it stops at the surface.
class HullAlgorithm : public btCollisionAlgorithm {
 public:
  HullAlgorithm(const btCollisionAlgorithmConstructionInfo& info,
                const btCollisionObjectWrapper* first, const btCollisionObjectWrapper* second)
      : btCollisionAlgorithm(info), hull_first_(polyhedron_of(*first) != nullptr) {
    const std::size_t n = is_triangle(hull_first_ ? *second : *first) ? 1 : most_planes;
    while (manifolds_.size() < n)
      manifolds_.push_back(
          m_dispatcher->getNewManifold(first->getCollisionObject(), second->getCollisionObject()));
  }
  ~HullAlgorithm() override {
    for (btPersistentManifold* manifold : manifolds_) m_dispatcher->releaseManifold(manifold);
  }

  void processCollision(const btCollisionObjectWrapper* first,
                        const btCollisionObjectWrapper* second, const btDispatcherInfo& info,
                        btManifoldResult* result) override {
    const btCollisionObjectWrapper &hull = hull_first_ ? *first : *second,
                                   &other = hull_first_ ? *second : *first;
    const double near = manifolds_.front()->getContactBreakingThreshold();
    before_.clear();
    for (const btPersistentManifold* manifold : manifolds_)
      for (int k = 0; k < manifold->getNumContacts(); ++k) {
        const btManifoldPoint& point = manifold->getContactPoint(k);
        const Vec3 normal =
            from_bullet(hull.getWorldTransform().getBasis().transpose() * point.m_normalWorldOnB);
        const bool towards_hull = manifold->getBody0() == hull.getCollisionObject();
        before_.push_back(
            {on_hull(hull, *manifold, point), towards_hull ? normal : Vec3(-normal), 0.0});
      }
    const ConvexPolyhedron& polyhedron = *polyhedron_of(hull);
    const btTransform to_end = relative_motion(hull, other, info.m_timeStep);
    const double reach = std::max(near, largest_motion(*hull.getCollisionShape(), to_end));
    const std::size_t n_met = collect(hull, other, reach);
    finder_.find(
        {polyhedron, triangles_, n_met, reach, flush_share * near, manifolds_.size(), before_},
        planes_);
    if (reach > near && !meets_at_end(polyhedron, to_end, n_met, near) &&
        !passes(polyhedron, to_end, n_met))
      remove_contacts_ahead(near);
    for (btPersistentManifold* manifold : manifolds_) manifold->setContactBreakingThreshold(reach);
    put_points(hull, near, *result);
    for (btPersistentManifold* manifold : manifolds_) manifold->setContactBreakingThreshold(near);
  }
  btScalar calculateTimeOfImpact(btCollisionObject*, btCollisionObject*, const btDispatcherInfo&,
                                 btManifoldResult*) override {
    return 1.0;  // Bullet calls this only with DISPATCH_CONTINUOUS, which is not used
  }
  void getAllContactManifolds(btManifoldArray& manifolds) override {
    for (btPersistentManifold* manifold : manifolds_) manifolds.push_back(manifold);
  }

 private:
  // Position of a contact point on the hull, in the axes of the hull.
  static Vec3 on_hull(const btCollisionObjectWrapper& hull, const btPersistentManifold& manifold,
                      const btManifoldPoint& point) {
    const btCollisionObject& body = *hull.getCollisionObject();
    const btVector3& local =
        manifold.getBody0() == &body ? point.m_localPointA : point.m_localPointB;
    return from_bullet(hull.getWorldTransform().invXform(body.getWorldTransform() * local));
  }

  // Returns whether the hull touches the other object after that object has moved by `motion`,
  // which is given in the axes of the hull. planes_ must contain the contacts before the motion.
  bool meets_at_end(const ConvexPolyhedron& hull, const btTransform& motion, std::size_t n_met,
                    double near) {
    if (planes_.empty()) return false;
    moved_ = triangles_;
    for (Corners& corners : moved_)
      for (Vec3& corner : corners) corner = from_bullet(motion * to_bullet(corner));
    HullOnTriangles::Contacts before;
    for (const auto& plane : planes_)
      for (const HullContact& contact : plane)
        before.push_back({contact.on_hull(), contact.normal, 0.0});
    finder_.find({hull, moved_, n_met, near, flush_share * near, manifolds_.size(), before},
                 planes_at_end_);
    return std::any_of(planes_at_end_.begin(), planes_at_end_.end(), [](const auto& plane) {
      return std::any_of(plane.begin(), plane.end(),
                         [](const HullContact& contact) { return contact.gap <= 0.0; });
    });
  }

  // Returns whether a triangle of the other object crosses an inner point of the hull when it moves
  // by `motion`, which is given in the axes of the hull. Tested points are the centre and a point
  // near each corner. This test is needed because a thin or small hull can pass through a surface
  // in one step, and meets_at_end() then finds no contact. planes_ must contain the contacts before
  // the motion.
  bool passes(const ConvexPolyhedron& hull, const btTransform& motion, std::size_t n_met) const {
    if (planes_.empty()) return false;
    // Position of a point between the centre (0) and a corner (1). Corners themselves would graze a
    // surface on which the hull lies.
    constexpr double towards_corner = 0.9;
    const btTransform back = motion.inverse();
    const auto crosses = [&](const Vec3& point) {
      const Vec3 end = from_bullet(back * to_bullet(point));
      const auto met_end = triangles_.begin() + static_cast<std::ptrdiff_t>(n_met);
      return std::any_of(triangles_.begin(), met_end, [&](const Corners& corners) {
        return crossing(point, end, corners).has_value();
      });
    };
    return crosses(hull.centre) ||
           std::any_of(hull.points.begin(), hull.points.end(), [&](const Vec3& point) {
             return crosses(hull.centre + towards_corner * (point - hull.centre));
           });
  }

  // Fills triangles_, in the axes of the hull: with the mesh triangles within about `near` [m] of
  // the hull's bounding box, or with a facet (facets.h) and then the triangles that share a corner
  // with it. Returns the number of triangles that can have contacts: all of a mesh, but only the
  // facet itself.
  std::size_t collect(const btCollisionObjectWrapper& hull, const btCollisionObjectWrapper& other,
                      double near) {
    triangles_.clear();
    if (is_triangle(other)) {
      const auto* facet =
          static_cast<const FacetSurroundings*>(other.getCollisionShape()->getUserPointer());
      const auto add = [&](const std::array<Index, 3>& corners) {
        Corners x;
        for (int k = 0; k < 3; ++k)
          x[k] = from_bullet(hull.getWorldTransform().invXform(
              to_bullet(Vec3(facet->vertices->row(corners[k]).transpose()))));
        triangles_.push_back(x);
      };
      add(facet->corners);
      for (const auto& around : facet->others) add(around);
      return 1;
    }
    const btTransform to_hull = hull.getWorldTransform().inverseTimes(other.getWorldTransform());
    btVector3 low, high;
    hull.getCollisionShape()->getAabb(to_hull.inverse(), low, high);
    const btVector3 wider(near, near, near);
    Collect found(to_hull, low - wider, high + wider, triangles_);
    static_cast<const btConcaveShape*>(other.getCollisionShape())
        ->processAllTriangles(&found, low - wider, high + wider);
    return triangles_.size();
  }

  // Removes contacts with a gap above `near`.
  void remove_contacts_ahead(double near) {
    for (auto& plane : planes_)
      std::erase_if(plane, [&](const HullContact& contact) { return contact.gap > near; });
    std::erase_if(planes_, [](const auto& plane) { return plane.empty(); });
  }

  // Returns the index of the unused manifold whose contact normal is closest to the given normal.
  // If the two normals differ too much (see still_same_plane), returns the index of an unused empty
  // manifold or, if there is none, clears the closest manifold and returns its index.
  std::size_t manifold_for(const btVector3& normal_on_second) const {
    std::size_t chosen = manifolds_.size();
    btScalar most = -2.0;
    for (std::size_t m = 0; m < manifolds_.size(); ++m) {
      if (used_[m]) continue;
      const bool empty = manifolds_[m]->getNumContacts() == 0;
      const btScalar along =
          empty ? still_same_plane
                : manifolds_[m]->getContactPoint(0).m_normalWorldOnB.dot(normal_on_second);
      if (along > most) chosen = m, most = along;
    }
    if (most < still_same_plane) manifolds_[chosen]->clearManifold();
    return chosen;
  }

  // Replaces the contact points of the previous step. A new point near an old one starts from the
  // impulse of the old one.
  void put_points(const btCollisionObjectWrapper& hull, double near, btManifoldResult& result) {
    // Bullet expects normals that point away from the second body.
    const bool towards_first = manifolds_.front()->getBody0() == hull.getCollisionObject();
    used_.assign(manifolds_.size(), false);
    for (const auto& plane : planes_) {
      const btVector3 direction =
          hull.getWorldTransform().getBasis() * to_bullet(plane.front().normal);
      const std::size_t m = manifold_for(towards_first ? direction : -direction);
      used_[m] = true;
      put_plane(hull, near, plane, *manifolds_[m]);
      result.setPersistentManifold(manifolds_[m]);
      result.refreshContactPoints();
    }
    for (std::size_t m = 0; m < manifolds_.size(); ++m)
      if (!used_[m] && manifolds_[m]->getNumContacts() > 0) manifolds_[m]->clearManifold();
    result.setPersistentManifold(manifolds_.front());
  }

  void put_plane(const btCollisionObjectWrapper& hull, double near,
                 const HullOnTriangles::Contacts& plane, btPersistentManifold& manifold) {
    const btTransform& pose = hull.getWorldTransform();
    const bool towards_first = manifold.getBody0() == hull.getCollisionObject();
    std::vector<std::pair<Vec3, btManifoldPoint>> old;  // with their places on the hull
    for (int k = 0; k < manifold.getNumContacts(); ++k) {
      const btManifoldPoint& point = manifold.getContactPoint(k);
      old.emplace_back(on_hull(hull, manifold, point), point);
    }
    manifold.setNumContacts(static_cast<int>(plane.size()));
    for (std::size_t k = 0; k < plane.size(); ++k) {
      const btVector3 normal = pose.getBasis() * to_bullet(plane[k].normal),
                      on_other = pose * to_bullet(plane[k].point),
                      on_body = on_other + plane[k].gap * normal;
      btManifoldPoint& point = manifold.getContactPoint(static_cast<int>(k));
      point = towards_first ? manifold_point(manifold, on_body, on_other, normal)
                            : manifold_point(manifold, on_other, on_body, -normal);
      const Vec3 place = plane[k].on_hull();
      const auto nearest = std::ranges::min_element(
          old, {}, [&](const auto& before) { return (before.first - place).squaredNorm(); });
      if (nearest == old.end() || (nearest->first - place).norm() >= near) continue;
      continue_from(nearest->second, point);
      old.erase(nearest);
    }
  }

  bool hull_first_;
  std::vector<btPersistentManifold*> manifolds_;  // one manifold per contact plane
  // Scratch memory.
  HullOnTriangles finder_;
  std::vector<Corners> triangles_, moved_;
  std::vector<HullOnTriangles::Contacts> planes_, planes_at_end_;
  HullOnTriangles::Contacts before_;
  std::vector<bool> used_;
};

}  // namespace

int HullAlgorithms::size() { return static_cast<int>(sizeof(HullAlgorithm)); }

void HullAlgorithms::enter(btCollisionDispatcher& dispatcher,
                           btCollisionConfiguration& configuration) {
  std::size_t k = 0;
  for (const int hull : {CONVEX_HULL_SHAPE_PROXYTYPE, BOX_SHAPE_PROXYTYPE})
    for (const int other : {TRIANGLE_MESH_SHAPE_PROXYTYPE, TRIANGLE_SHAPE_PROXYTYPE})
      for (const auto& [first, second] : {std::pair(hull, other), std::pair(other, hull)}) {
        create_[k].others = configuration.getCollisionAlgorithmCreateFunc(first, second);
        dispatcher.registerCollisionCreateFunc(first, second, &create_[k++]);
      }
}

btCollisionAlgorithm* HullAlgorithms::Create::CreateCollisionAlgorithm(
    btCollisionAlgorithmConstructionInfo& info, const btCollisionObjectWrapper* first,
    const btCollisionObjectWrapper* second) {
  if (!polyhedron_of(*first) && !polyhedron_of(*second))
    return with_contacts_ahead(info, *others, first, second);
  return new (info.m_dispatcher1->allocateCollisionAlgorithm(size()))
      HullAlgorithm(info, first, second);
}

}  // namespace loomstone
