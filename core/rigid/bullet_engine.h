// Bullet's world with its solver and contact cache: everything that a restart of the rigid world
// builds again.
#pragma once

#include <memory>
#include <vector>

#include "core/base/rotation.h"
#include "core/rigid/bullet.h"
#include "core/rigid/hull_algorithm.h"
#include "core/rigid/sphere_algorithm.h"

namespace loomstone {

// Keeps bounding boxes tight. Each box grows by the distance within which its shape makes contacts,
// which is proportional to its size, not by Bullet's 2 cm. In the tree the boxes of bodies are
// wider by a few of these distances and stay until a body leaves its box. Bullet would enlarge them
// by 5 cm as soon as they move, within which a small body has hundreds of neighbours.
//
// Obstacles stand at their pose at the start of the step and have the velocity that leads to its
// end, like the bodies. Their velocities are given; Bullet would compute them by differences, and
// its arc cosine turns rounding into a spin of 1e-8 / step.
class BulletWorld : public btDiscreteDynamicsWorld {
 public:
  using btDiscreteDynamicsWorld::btDiscreteDynamicsWorld;

  void updateAabbs() override;

 protected:
  void saveKinematicState(btScalar) override {}

 private:
  std::vector<btScalar> margins_;  // of the objects, which are never removed
};

// Members are destroyed in reverse order: the world before the objects it refers to.
struct BulletEngine {
  btDefaultCollisionConfiguration configuration;
  SphereAlgorithms spheres;
  HullAlgorithms hulls;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  // Dynamic bodies, then obstacles that keep their shape, then facets of those that deform.
  std::vector<std::unique_ptr<btRigidBody>> bodies;
  BulletWorld world{&dispatcher, &broadphase, &solver, &configuration};

  BulletEngine(const Vec3& gravity, int iterations);
  ~BulletEngine();

  btRigidBody& add(double mass, const Vec3& inertia, btCollisionShape& shape, double friction,
                   double restitution);
  btRigidBody& add_obstacle(btCollisionShape& shape, double friction);
};

void set_pose(btRigidBody& body, const btTransform& pose);
void set_velocity(btRigidBody& body, const Vec3& velocity, const Vec3& angular_velocity);

inline btTransform bullet_pose(const RigidPose& pose) {
  return btTransform(to_bullet(rotation_matrix(pose.orientation)), to_bullet(pose.position));
}

}  // namespace loomstone
