// Bullet's world with its solver and contact cache. RigidWorld::restore() rebuilds all of it.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "core/base/rotation.h"
#include "core/rigid/bullet.h"
#include "core/rigid/cone_friction.h"
#include "core/rigid/hull_algorithm.h"
#include "core/rigid/pair_algorithm.h"
#include "core/rigid/sphere_algorithm.h"

namespace loomstone {

// Bullet's world with tight bounding boxes. The box of a shape encloses the shape at the start of
// the step and, if it keeps its velocities, at the end. It is enlarged by the contact distance of
// the shape (Bullet's contact breaking threshold), which is proportional to the shape's size and at
// most 2 cm. Bullet would always use 2 cm. The tree of boxes contains a still larger box of each
// body, with a few further contact distances on each side. This larger box is updated only when the
// smaller one leaves it or when it has become far too large. Bullet would enlarge the box of a
// moving body by 5 cm, so the box of a small body could overlap hundreds of neighbours.
//
// During a step, an obstacle has the pose of the start of the step and the velocity that leads to
// its pose at the end. A facet (a triangle of a deforming obstacle, facets.h) has the velocity of
// its best-fit rigid motion. These velocities are set explicitly. Bullet would compute them from
// pose differences with an arc cosine, which amplifies rounding errors to a rotation of 1e-8 rad
// per step.
//
// Restitution does not act on the kicks of the step (velocity changes by forces), nor on gravity,
// because forces that press two bodies together should not make them bounce. A body bounces in the
// step in which it reaches the other body, even if there is still a gap at the start of the step.
// Without this rule, Bullet would brake the body to the speed that closes the gap in this step, and
// the body would not rebound.
//
// Bullet's continuous detection is not used. It sweeps a sphere by an iteration. If the sphere
// slides along a surface, this iteration does not converge, and the body is stopped or deflected.
// The collision algorithms of this directory find contacts ahead of the motion instead, and
// surface_guard.h checks the result.
class BulletWorld : public btDiscreteDynamicsWorld {
 public:
  // Changes of a body's velocities by forces [m/s], [rad/s].
  struct Kick {
    btVector3 linear, angular;
  };
  // Kicks of the dynamic bodies. If `half` is not empty, the velocities at the start and end of the
  // step are those of kick-drift-kick. In that case, the previous step ended with a half kick,
  // which does not count as approach speed. This step also ends with a half kick, and the speed of
  // the rebound is the speed after it.
  struct Kicks {
    // Kicks by all impulses of the step. The velocities of the bodies already contain them.
    std::vector<Kick> whole;
    std::vector<Kick> half;  // half kicks by the forces of kick-drift-kick; may be empty
  };

  using btDiscreteDynamicsWorld::btDiscreteDynamicsWorld;

  void set_kicks(Kicks kicks) { kicks_ = std::move(kicks); }
  void updateAabbs() override;

 protected:
  void saveKinematicState(btScalar) override {}
  // Sets the interpolation transforms of bodies and obstacles to the poses to which their present
  // velocities lead in the step. Bullet's function leaves out obstacles.
  void predictUnconstraintMotion(btScalar step) override;
  void solveConstraints(btContactSolverInfo& info) override;
  void integrateTransforms(btScalar step) override;

 private:
  void set_restitution(const btPersistentManifold& manifold, double restitution,
                       const btContactSolverInfo& info, btManifoldPoint& point) const;

  std::vector<btScalar> margins_;  // contact distance of each object of the world [m]
  std::vector<btVector3> before_;  // positions of m_nonStaticRigidBodies at the step's start [m]
  Kicks kicks_;
};

// Bullet's world and the objects that it refers to. Members are destroyed in reverse order, so the
// world is destroyed before these objects.
struct BulletEngine {
  btDefaultCollisionConfiguration configuration;
  SphereAlgorithms spheres;
  HullAlgorithms hulls;
  PairAlgorithms pairs;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  ConeFrictionSolver solver;
  // Dynamic bodies, then obstacles of constant shape, then facets of deforming obstacles.
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
