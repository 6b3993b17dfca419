// Bullet's headers (double precision), and conversions of vectors and matrices between Bullet and
// Eigen. No other file includes Bullet's headers, and only files of this directory may include this
// one.
#pragma once

#include <BulletCollision/CollisionShapes/btTriangleShape.h>
#include <LinearMath/btConvexHullComputer.h>
#include <btBulletDynamicsCommon.h>

#include "core/base/types.h"

namespace loomstone {

inline btVector3 to_bullet(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
inline Vec3 from_bullet(const btVector3& v) { return {v.x(), v.y(), v.z()}; }
inline btMatrix3x3 to_bullet(const Mat3& m) {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2)};
}
inline Mat3 from_bullet(const btMatrix3x3& m) {
  Mat3 r;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) r(i, j) = m[i][j];
  return r;
}

}  // namespace loomstone
