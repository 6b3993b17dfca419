#include "core/rigid/pair_algorithm.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <vector>

#include "core/rigid/manifold_point.h"
#include "core/rigid/step_motion.h"

namespace loomstone {

namespace {

struct Overlap {
  btVector3 normal, on_second;  // the normal points from the second to the first body
  btScalar gap;
};

// Collects the overlaps that an algorithm finds. The manifold of the algorithm stays unchanged.
class Overlaps : public btManifoldResult {
 public:
  Overlaps(const btCollisionObjectWrapper* first, const btCollisionObjectWrapper* second,
           std::vector<Overlap>& found)
      : btManifoldResult(first, second), found_(found) {}
  void addContactPoint(const btVector3& normal, const btVector3& on_second, btScalar gap) override {
    if (gap <= 0.0) found_.push_back({normal, on_second, gap});
  }

 private:
  std::vector<Overlap>& found_;
};

class PairAlgorithm final : public btCollisionAlgorithm {
 public:
  PairAlgorithm(const btCollisionAlgorithmConstructionInfo& info, btCollisionAlgorithm* bullets)
      : btCollisionAlgorithm(info), bullets_(bullets) {}
  ~PairAlgorithm() override {
    bullets_->~btCollisionAlgorithm();
    m_dispatcher->freeCollisionAlgorithm(bullets_);
  }

  void processCollision(const btCollisionObjectWrapper* first,
                        const btCollisionObjectWrapper* second, const btDispatcherInfo& info,
                        btManifoldResult* result) override {
    bullets_->processCollision(first, second, info, result);
    manifolds_.resize(0);
    bullets_->getAllContactManifolds(manifolds_);
    if (manifolds_.size() != 1 || manifolds_[0]->getNumContacts() > 0) return;
    btPersistentManifold& manifold = *manifolds_[0];
    const btScalar near = manifold.getContactBreakingThreshold();
    const double motion = largest_motion(*first->getCollisionShape(),
                                         relative_motion(*first, *second, info.m_timeStep));
    if (motion <= near) return;
    manifold.setContactBreakingThreshold(motion);
    const int parts = parts_of(*first->getCollisionShape(), *second->getCollisionShape(), motion);
    add_contacts_ahead(*first, *second, info, parts, manifold);
    manifold.setContactBreakingThreshold(near);
  }
  btScalar calculateTimeOfImpact(btCollisionObject*, btCollisionObject*, const btDispatcherInfo&,
                                 btManifoldResult*) override {
    return 1.0;  // Bullet calls this only with DISPATCH_CONTINUOUS, which is not used
  }
  void getAllContactManifolds(btManifoldArray& manifolds) override {
    bullets_->getAllContactManifolds(manifolds);
  }

 private:
  // Number of equal parts of the step at whose ends overlaps are searched for.
  static int parts_of(const btCollisionShape& first, const btCollisionShape& second,
                      double motion) {
    constexpr double most_parts = 32.0;
    const double size = std::min(inner_size(first), inner_size(second));
    return static_cast<int>(std::ceil(std::clamp(motion / size, 1.0, most_parts)));
  }
  // Inner radius of a convex body [m], or infinity for surfaces.
  static double inner_size(const btCollisionShape& shape) {
    return shape.isConvex() && shape.getShapeType() != TRIANGLE_SHAPE_PROXYTYPE
               ? inner_radius(shape)
               : std::numeric_limits<double>::infinity();
  }

  // Tests the shapes at the ends of `parts` equal parts of the step. At the first of these times at
  // which the shapes overlap, adds a contact for each point in found_, moved back to the poses at
  // the start of the step (see PairAlgorithms).
  void add_contacts_ahead(const btCollisionObjectWrapper& first,
                          const btCollisionObjectWrapper& second, const btDispatcherInfo& info,
                          int parts, btPersistentManifold& manifold) {
    for (int k = 1; k <= parts; ++k) {
      const btScalar share = static_cast<btScalar>(k) / parts;
      const btTransform later_first = pose_after(first, info.m_timeStep, share),
                        later_second = pose_after(second, info.m_timeStep, share);
      find_overlaps(moved(first, later_first), moved(second, later_second), info);
      if (found_.empty()) continue;
      const btTransform back_first = first.getWorldTransform() * later_first.inverse(),
                        back_second = second.getWorldTransform() * later_second.inverse();
      for (const Overlap& overlap : found_) {
        const btVector3 on_first = back_first * (overlap.on_second + overlap.normal * overlap.gap),
                        on_second = back_second * overlap.on_second;
        if (overlap.normal.dot(on_first - on_second) <= 0.0) continue;
        const bool in_order = manifold.getBody0() == first.getCollisionObject();
        manifold.addManifoldPoint(
            in_order ? manifold_point(manifold, on_first, on_second, overlap.normal)
                     : manifold_point(manifold, on_second, on_first, -overlap.normal));
      }
      return;
    }
  }
  static btCollisionObjectWrapper moved(const btCollisionObjectWrapper& shape,
                                        const btTransform& pose) {
    return btCollisionObjectWrapper(shape.m_parent, shape.getCollisionShape(),
                                    shape.getCollisionObject(), pose, shape.m_partId,
                                    shape.m_index);
  }
  // Fills found_.
  void find_overlaps(const btCollisionObjectWrapper& first, const btCollisionObjectWrapper& second,
                     const btDispatcherInfo& info) {
    found_.clear();
    Overlaps overlaps(&first, &second, found_);
    bullets_->processCollision(&first, &second, info, &overlaps);
  }

  btCollisionAlgorithm* bullets_;  // Bullet's algorithm for this pair
  // Scratch memory.
  btManifoldArray manifolds_;
  std::vector<Overlap> found_;
};

}  // namespace

int PairAlgorithms::size() { return static_cast<int>(sizeof(PairAlgorithm)); }

void PairAlgorithms::enter(btCollisionDispatcher& dispatcher,
                           btCollisionConfiguration& configuration) {
  const std::array<int, 3> types = {SPHERE_SHAPE_PROXYTYPE, CONVEX_HULL_SHAPE_PROXYTYPE,
                                    BOX_SHAPE_PROXYTYPE};
  std::size_t k = 0;
  for (const int first : types)
    for (const int second : types) {
      if (first == SPHERE_SHAPE_PROXYTYPE && second == SPHERE_SHAPE_PROXYTYPE) continue;
      create_[k].bullets = configuration.getCollisionAlgorithmCreateFunc(first, second);
      dispatcher.registerCollisionCreateFunc(first, second, &create_[k++]);
    }
}

btCollisionAlgorithm* PairAlgorithms::Create::CreateCollisionAlgorithm(
    btCollisionAlgorithmConstructionInfo& info, const btCollisionObjectWrapper* first,
    const btCollisionObjectWrapper* second) {
  return with_contacts_ahead(info, *bullets, first, second);
}

btCollisionAlgorithm* with_contacts_ahead(btCollisionAlgorithmConstructionInfo& info,
                                          btCollisionAlgorithmCreateFunc& bullets,
                                          const btCollisionObjectWrapper* first,
                                          const btCollisionObjectWrapper* second) {
  btCollisionAlgorithm* const inner = bullets.CreateCollisionAlgorithm(info, first, second);
  return new (info.m_dispatcher1->allocateCollisionAlgorithm(PairAlgorithms::size()))
      PairAlgorithm(info, inner);
}

}  // namespace loomstone
