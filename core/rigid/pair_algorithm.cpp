#include "core/rigid/pair_algorithm.h"

#include <new>
#include <vector>

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
    add_contacts_ahead(*first, *second, info, *result);
    manifold.setContactBreakingThreshold(near);
  }
  btScalar calculateTimeOfImpact(btCollisionObject*, btCollisionObject*, const btDispatcherInfo&,
                                 btManifoldResult*) override {
    return 1.0;  // called only in continuous dispatch, which is not used
  }
  void getAllContactManifolds(btManifoldArray& manifolds) override {
    bullets_->getAllContactManifolds(manifolds);
  }

 private:
  void add_contacts_ahead(const btCollisionObjectWrapper& first,
                          const btCollisionObjectWrapper& second, const btDispatcherInfo& info,
                          btManifoldResult& result) {
    const btTransform end_first = pose_after(first, info.m_timeStep),
                      end_second = pose_after(second, info.m_timeStep);
    const auto moved = [](const btCollisionObjectWrapper& shape, const btTransform& pose) {
      return btCollisionObjectWrapper(shape.m_parent, shape.getCollisionShape(),
                                      shape.getCollisionObject(), pose, shape.m_partId,
                                      shape.m_index);
    };
    const btCollisionObjectWrapper later_first = moved(first, end_first),
                                   later_second = moved(second, end_second);
    found_.clear();
    Overlaps overlaps(&later_first, &later_second, found_);
    bullets_->processCollision(&later_first, &later_second, info, &overlaps);
    const btTransform back_first = first.getWorldTransform() * end_first.inverse(),
                      back_second = second.getWorldTransform() * end_second.inverse();
    for (const Overlap& overlap : found_) {
      const btVector3 on_first = back_first * (overlap.on_second + overlap.normal * overlap.gap),
                      on_second = back_second * overlap.on_second;
      const btScalar gap = overlap.normal.dot(on_first - on_second);
      if (gap > 0.0) result.addContactPoint(overlap.normal, on_second, gap);
    }
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
  btCollisionAlgorithm* const inner = bullets->CreateCollisionAlgorithm(info, first, second);
  return new (info.m_dispatcher1->allocateCollisionAlgorithm(size())) PairAlgorithm(info, inner);
}

}  // namespace loomstone
