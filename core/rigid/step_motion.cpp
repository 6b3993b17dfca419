#include "core/rigid/step_motion.h"

namespace loomstone {

btTransform pose_after(const btCollisionObjectWrapper& shape, btScalar step, btScalar share) {
  const auto& body = static_cast<const btRigidBody&>(*shape.getCollisionObject());
  const btTransform& pose = body.getWorldTransform();
  const btVector3 velocity =
      body.getLinearVelocity() + body.getGravity() * body.getLinearFactor() * step;
  btTransform end;
  btTransformUtil::integrateTransform(pose, velocity, body.getAngularVelocity(), step * share, end);
  return end * pose.inverse() * shape.getWorldTransform();
}

btTransform relative_motion(const btCollisionObjectWrapper& first,
                            const btCollisionObjectWrapper& second, btScalar step) {
  return pose_after(first, step).inverse() * pose_after(second, step) *
         second.getWorldTransform().inverse() * first.getWorldTransform();
}

double largest_motion(const btCollisionShape& shape, const btTransform& motion) {
  btVector3 centre;
  btScalar radius;
  shape.getBoundingSphere(centre, radius);
  return (motion * centre - centre).length() + motion.getRotation().getAngleShortestPath() * radius;
}

double inner_radius(const btCollisionShape& shape) {
  btVector3 low, high;
  shape.getAabb(btTransform::getIdentity(), low, high);
  return 0.5 * from_bullet(high - low).minCoeff();
}

}  // namespace loomstone
