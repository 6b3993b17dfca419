// Collision shapes of Bullet for bodies, and its vectors as ours. Included by rigid_world.cpp alone.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <memory>
#include <string>
#include <vector>

#include "core/rigid/rigid_body.h"

namespace loomstone {

inline btVector3 to_bullet(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
inline Vec3 from_bullet(const btVector3& v) { return {v.x(), v.y(), v.z()}; }
inline btMatrix3x3 to_bullet(const Mat3& m) {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2)};
}
inline Mat3 from_bullet(const btMatrix3x3& m) {
  Mat3 r;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) r(i, j) = m[i][j];
  }
  return r;
}

using Shapes = std::vector<std::unique_ptr<btCollisionShape>>;

// Adds the body's shape, and those it consists of, to `shapes`; the one of the whole body comes last.
void add_shapes(const RigidBody& body, const MassProperties& mass, const Mat3& principal, const std::string& where,
                Shapes& shapes);

}  // namespace loomstone
