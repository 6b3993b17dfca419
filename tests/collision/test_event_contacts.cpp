// Tests of the search for pairs of features that may touch within a step, and of the impulses
// between them.
#include <algorithm>
#include <catch2/catch.hpp>

#include "core/collision/collision_stage.h"
#include "core/collision/detector.h"
#include "core/collision/event_contacts.h"
#include "tests/collision/collision_scenes.h"

using namespace loomstone;

namespace {

// Two sheets, 6 mm apart, one above the other.
TestScene two_sheets() {
  return make_scene({{jittered_grid(0.2, 0.2, 9, 9, 0.2, 1)},
                     {jittered_grid(0.18, 0.18, 8, 8, 0.2, 2).moved(Vec3(0.01, 0.0, 0.006))}});
}

Points velocities(const TestScene& scene, double speed) {
  Points v = shaken(Points::Zero(scene.x.rows(), 3), 0.5 * speed, 4);
  for (Index i = 0; i < v.rows(); ++i)
    if (scene.x(i, 2) > 0.003) v.row(i) += Vec3(0.3, 0.1, -speed).transpose();
  return v;
}

bool has(const Approach& approach, ContactKind kind, PairKey key) {
  return std::any_of(approach.pairs.begin(), approach.pairs.end(),
                     [&](const auto& pair) { return pair.kind == kind && pair.key == key; });
}

}  // namespace

TEST_CASE("every pair that meets at constant velocity is registered, and few others") {
  const TestScene scene = two_sheets();
  const double step = 2.5e-3;
  for (const double speed : {0.5, 3.0, 6.0}) {
    const Points v = velocities(scene, speed);
    CollisionStage stage(scene.model);
    const Approach found = stage.approach({}, {scene.x, v, step}, {});
    Detector detector(scene.model.triangles);
    const Points end = scene.x + step * v;
    const Collisions meeting = detector.collisions({}, scene.x, end);
    for (const auto& [a, b] : meeting.pairs.vertex_face)
      CHECK(has(found, ContactKind::VertexFace, pair_key(a, b)));
    for (const auto& [a, b] : meeting.pairs.edge_edge)
      CHECK(has(found, ContactKind::EdgeEdge, pair_key(a, b)));
    CAPTURE(speed, found.candidates, found.pairs.size());
    CHECK(static_cast<std::int64_t>(found.pairs.size()) <= found.candidates);
    if (speed > 4.0) CHECK(meeting.pairs.vertex_face.size() + meeting.pairs.edge_edge.size() > 20);
    if (speed < 1.0) CHECK(2 * found.pairs.size() < static_cast<std::size_t>(found.candidates));
  }
}

TEST_CASE("the registered pairs do not depend on earlier steps, or on the decomposition") {
  const TestScene scene = two_sheets();
  const double step = 2.5e-3;
  CollisionStage used(scene.model), whole(scene.model, Decomposition::Static);
  Points x = scene.x;
  for (int i = 0; i < 120; ++i) {
    // In the fast steps, the neighbour lists of `used` do not last.
    const double speed = i % 100 >= 20 && i % 100 < 25 ? 8.0 : 0.4;
    const Points v = velocities(scene, (i % 2 == 0 ? 1.0 : -1.0) * speed);
    if (i % 4 == 0) used.proximity({}, x, {});
    const Approach found = used.approach({}, {x, v, step}, {});
    CollisionStage fresh(scene.model);
    for (CollisionStage* other : {&whole, &fresh}) {
      const Approach expected = other->approach({}, {x, v, step}, {});
      CHECK(found.candidates == expected.candidates);
      REQUIRE(found.pairs.size() == expected.pairs.size());
      for (std::size_t k = 0; k < found.pairs.size(); ++k) {
        CHECK(found.pairs[k].key == expected.pairs[k].key);
        CHECK(found.pairs[k].contact == expected.pairs[k].contact);
        CHECK(found.pairs[k].wake == expected.pairs[k].wake);
      }
    }
    x += step * v;
  }
}

TEST_CASE("at events, a vertex falls onto a face without crossing it, at any phase of its level") {
  TriangleMesh face = grid_cells(0.1, 0.1, 1, 1);
  Points corner(3, 3);
  corner << 0.01, 0.02, 0.004, 0.02, 0.02, 0.05, 0.01, 0.03, 0.05;
  Triangles one(1, 3);
  one << 0, 1, 2;
  const TestScene scene =
      make_scene({{{corner, one}}, {face, CollisionSurface::Kind::Script, 2e-3, 0.0}});
  const double step = 2.5e-3;
  const Index n_ticks = 16;
  Points v = Points::Zero(scene.x.rows(), 3);
  v.topRows(3).col(2).setConstant(-2.0);  // 5 mm in a step; the gap is 4 mm, the thickness 2 mm
  const ExpectedMotion motion{scene.x, v, step};
  CollisionStage stage(scene.model);
  const std::vector<SurfacePair> pairs = surface_pairs(scene.model);
  const std::vector<double> length = {step / 4, step / 8, step / 16};
  for (const std::uint8_t lowest : {0, 1, 2}) {
    EventContacts contacts(scene.model, pairs, scene.inverse_mass);
    contacts.set_pairs(motion, stage.approach({}, motion, {}).pairs);
    contacts.begin(n_ticks);
    Points x = scene.x.topRows(3), u = v.topRows(3);
    const std::vector<std::uint8_t> level = {lowest, 0, 1};
    for (Index tick = 0; tick < n_ticks; ++tick) {
      std::vector<double> ahead(3);
      for (int k = 0; k < 3; ++k) {
        const Index ticks = Index{4} >> k, since = tick % ticks;
        ahead[k] = since == 0 ? 0.0 : static_cast<double>(ticks - since) * step / n_ticks;
      }
      std::vector<EventBody> bodies;
      const Points kicks = Points::Zero(3, 3);
      const EventMotion::Levels levels{level, length, ahead};
      contacts.act({}, tick, {x, u, bodies, kicks, &levels});
      for (int i = 0; i < 3; ++i)
        if (ahead[level[i]] == 0.0) x.row(i) += length[level[i]] * u.row(i);
    }
    CAPTURE(static_cast<int>(lowest));
    CHECK(contacts.n_impulses() > 0);
    CHECK(x(0, 2) > 0.0);
    CHECK(u(0, 2) >= 0.0);
    // An impulse makes a pair separate by at most a tenth of the thickness per step (0.08 m/s). The
    // bound leaves a margin.
    CHECK(u(0, 2) < 0.2);
    CHECK(u(1, 2) == -2.0);
  }
}

TEST_CASE("at events, a vertex beside an edge of a face is pushed along the normal of the face") {
  // The vertex is 1 mm above the face, over a point that is 1 mm from edge E of the face. Its
  // distance of 1.4 mm from E is less than the thickness of 2 mm. The two cloth edges that end at
  // the vertex are closest to E at the vertex itself, so their pairs with E exert no impulse.
  Points corners(3, 3), above(3, 3);
  corners << 0, 0, 0, 0.1, 0, 0, 0, 0.1, 0;
  above << 0.04, 0.001, 0.001, 0.03, 0.002, 0.05, 0.05, 0.002, 0.05;
  Triangles one(1, 3);
  one << 0, 1, 2;
  const TestScene scene =
      make_scene({{{above, one}}, {{corners, one}, CollisionSurface::Kind::Script, 2e-3, 0.0}});
  const double step = 1e-3;
  Points v = Points::Zero(scene.x.rows(), 3);
  v.topRows(3).col(2).setConstant(-0.5);
  const ExpectedMotion motion{scene.x, v, step};
  CollisionStage stage(scene.model);
  const std::vector<SurfacePair> pairs = surface_pairs(scene.model);
  EventContacts contacts(scene.model, pairs, scene.inverse_mass);
  contacts.set_pairs(motion, stage.approach({}, motion, {}).pairs);
  contacts.begin(4);
  Points x = scene.x.topRows(3), u = v.topRows(3);
  const std::vector<std::uint8_t> level(3, 0);
  const std::vector<double> length = {step / 4}, ahead = {0.0};
  const EventMotion::Levels levels{level, length, ahead};
  std::vector<EventBody> bodies;
  const Points kicks = Points::Zero(3, 3);
  for (Index tick = 0; tick < 4; ++tick) {
    contacts.act({}, tick, {x, u, bodies, kicks, &levels});
    x += length[0] * u;
  }
  CHECK(contacts.n_impulses() > 0);
  CHECK(u(0, 0) == 0.0);
  CHECK(u(0, 1) == 0.0);
  CHECK(u(0, 2) > 0.0);
}
