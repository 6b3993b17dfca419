#include "core/rigid/surface_guard.h"

#include <algorithm>
#include <array>

#include "core/rigid/contacts/crossing.h"
#include "core/rigid/step_motion.h"

namespace loomstone {

namespace {

// Straight path of a point relative to an obstacle, in the axes of the obstacle. Finds the first
// crossing of the path with a triangle.
class PathOfCentre : public btTriangleCallback {
 public:
  PathOfCentre(const btVector3& from, const btVector3& to) : from_(from), to_(to) {}
  void processTriangle(btVector3* corners, int, int) override {
    const auto share =
        crossing(from_bullet(from_), from_bullet(to_),
                 {from_bullet(corners[0]), from_bullet(corners[1]), from_bullet(corners[2])});
    if (share) first_ = std::min(first_, *share);
  }
  // Returns the share of the path up to the first crossing [1], or 2 if there is none.
  double first_crossing(btCollisionShape& surface) {
    btVector3 low = from_, high = from_;
    low.setMin(to_), high.setMax(to_);
    if (surface.isConcave()) {
      static_cast<btConcaveShape&>(surface).processAllTriangles(this, low, high);
    } else {
      processTriangle(static_cast<btTriangleShape&>(surface).m_vertices1, 0, 0);
    }
    return first_;
  }

 private:
  btVector3 from_, to_;
  double first_ = 2.0;
};

// Moves a body back in front of the surfaces that its centre has crossed.
class SurfacesOnPath : public btBroadphaseAabbCallback {
 public:
  SurfacesOnPath(const btVector3& from, btRigidBody& body) : from_(from), body_(body) {}
  bool process(const btBroadphaseProxy* proxy) override {
    auto& surface = *static_cast<btRigidBody*>(proxy->m_clientObject);
    if (!surface.isKinematicObject()) return true;
    btCollisionShape& shape = *surface.getCollisionShape();
    const btTransform& end = surface.getInterpolationWorldTransform();  // at the end of the step
    const btVector3 start = surface.getWorldTransform().invXform(from_),
                    way = end.invXform(body_.getWorldTransform().getOrigin()) - start;
    const double share = PathOfCentre(start, start + way).first_crossing(shape);
    if (share > 1.0) return true;
    const double kept =
        std::max(0.0, share - inner_radius(*body_.getCollisionShape()) / way.length());
    body_.getWorldTransform().setOrigin(end * (start + kept * way));
    return true;
  }

 private:
  btVector3 from_;
  btRigidBody& body_;
};

}  // namespace

void stop_at_surfaces(btBroadphaseInterface& broadphase, const btVector3& from, btRigidBody& body) {
  const btCollisionShape& shape = *body.getCollisionShape();
  const btVector3 to = body.getWorldTransform().getOrigin();
  if (!shape.isConvex() || (to - from).length() < 0.01 * inner_radius(shape)) return;
  btVector3 low = from, high = from;
  low.setMin(to), high.setMax(to);
  SurfacesOnPath surfaces(from, body);
  broadphase.aabbTest(low, high, surfaces);
}

}  // namespace loomstone
