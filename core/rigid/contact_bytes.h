// Serialisation of Bullet's contact points and of the positions of obstacles (ObstaclePlaces).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <type_traits>
#include <utility>

#include "core/rigid/bullet.h"
#include "core/rigid/byte_stream.h"
#include "core/rigid/rigid_body.h"

namespace loomstone {

// Calls `visit` for every field of a contact point that Bullet keeps between steps: 35 real
// numbers, then 6 integers.
template <class Point, class Visitor>
void for_each_field_of(Point& p, Visitor&& visit) {
  for (auto* vector :
       {&p.m_localPointA, &p.m_localPointB, &p.m_positionWorldOnA, &p.m_positionWorldOnB,
        &p.m_normalWorldOnB, &p.m_lateralFrictionDir1, &p.m_lateralFrictionDir2}) {
    for (int i = 0; i < 3; ++i) visit((*vector)[i]);
  }
  for (auto* number :
       {&p.m_distance1, &p.m_combinedFriction, &p.m_combinedRollingFriction,
        &p.m_combinedSpinningFriction, &p.m_combinedRestitution, &p.m_appliedImpulse, &p.m_prevRHS,
        &p.m_appliedImpulseLateral1, &p.m_appliedImpulseLateral2, &p.m_contactMotion1,
        &p.m_contactMotion2, &p.m_contactCFM, &p.m_contactERP, &p.m_frictionCFM}) {
    visit(*number);
  }
  for (auto* number : {&p.m_partId0, &p.m_partId1, &p.m_index0, &p.m_index1, &p.m_contactPointFlags,
                       &p.m_lifeTime}) {
    visit(*number);
  }
}

inline void write_manifold(ByteWriter& bytes, const btPersistentManifold& manifold) {
  bytes.write<std::int32_t>(manifold.getBody0()->getUserIndex());
  bytes.write<std::int32_t>(manifold.getBody1()->getUserIndex());
  bytes.write<std::int32_t>(manifold.getNumContacts());
  for (int k = 0; k < manifold.getNumContacts(); ++k) {
    std::array<double, 35> reals;
    std::array<int, 6> whole;
    std::size_t n_reals = 0, n_whole = 0;
    for_each_field_of(manifold.getContactPoint(k), [&](const auto& value) {
      if constexpr (std::is_same_v<std::decay_t<decltype(value)>, double>) {
        reals[n_reals++] = value;
      } else {
        whole[n_whole++] = value;
      }
    });
    bytes.write_all(reals.data(), n_reals);
    bytes.write_all(whole.data(), n_whole);
  }
}

// Copies the points of each saved manifold to the dispatcher's first unused manifold of the same
// pair of bodies. If there is none, the boxes of the pair do not overlap, so the pair has no
// contacts, and the saved points are dropped.
inline void read_manifolds(ByteReader& bytes, btCollisionDispatcher& dispatcher) {
  std::map<std::pair<int, int>, std::deque<btPersistentManifold*>> unused;
  for (int k = 0; k < dispatcher.getNumManifolds(); ++k) {
    btPersistentManifold* manifold = dispatcher.getManifoldByIndexInternal(k);
    unused[{manifold->getBody0()->getUserIndex(), manifold->getBody1()->getUserIndex()}].push_back(
        manifold);
  }
  const int n_manifolds = bytes.read<std::int32_t>();
  for (int m = 0; m < n_manifolds; ++m) {
    const int first = bytes.read<std::int32_t>(), second = bytes.read<std::int32_t>(),
              n_points = bytes.read<std::int32_t>();
    bytes.require(0 <= n_points && n_points <= MANIFOLD_CACHE_SIZE);
    btPersistentManifold* target = nullptr;
    if (auto& left = unused[{first, second}]; !left.empty())
      target = left.front(), left.pop_front();
    for (int k = 0; k < n_points; ++k) {
      btManifoldPoint point;
      for_each_field_of(point,
                        [&](auto& value) { value = bytes.read<std::decay_t<decltype(value)>>(); });
      if (target) target->addManifoldPoint(point);
    }
  }
  bytes.require(bytes.at_end());
}

// Writes the poses of obstacles and the vertices of deforming obstacles. In RigidState::manifolds,
// these precede the contact points.
inline void write_places(ByteWriter& bytes, const ObstaclePlaces& places) {
  bytes.write<std::int32_t>(static_cast<std::int32_t>(places.poses.size()));
  for (const RigidPose& pose : places.poses) {
    for (int k = 0; k < 3; ++k) bytes.write(pose.position[k]);
    for (int k = 0; k < 4; ++k) bytes.write(pose.orientation[k]);
  }
  for (const double coordinate : places.deformed.reshaped<Eigen::RowMajor>())
    bytes.write(coordinate);
}

// Reads what write_places() has written. `places` must already have the expected numbers of poses
// and vertices.
inline void read_places(ByteReader& bytes, ObstaclePlaces& places) {
  bytes.require(bytes.read<std::int32_t>() == static_cast<std::int32_t>(places.poses.size()));
  for (RigidPose& pose : places.poses) {
    for (int k = 0; k < 3; ++k) pose.position[k] = bytes.read<double>();
    for (int k = 0; k < 4; ++k) pose.orientation[k] = bytes.read<double>();
  }
  for (double& coordinate : places.deformed.reshaped<Eigen::RowMajor>())
    coordinate = bytes.read<double>();
}

}  // namespace loomstone
