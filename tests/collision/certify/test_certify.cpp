#include <catch2/catch.hpp>

#include "core/collision/collision_stage.h"
#include "core/collision/tangle/intersections.h"
#include "tests/collision/collision_scenes.h"

using namespace loomstone;
using Kind = CollisionSurface::Kind;

namespace {

FreeBodies none;

TestScene facing_sheets() {
  return make_scene(
      {{grid_cells(0.2, 0.2, 16, 16), Kind::Cloth, 2e-3},
       {jittered_grid(0.2, 0.2, 15, 15, 0.2, 3).moved(Vec3(4e-3, 1e-3, 0.02)), Kind::Cloth, 2e-3}});
}

}  // namespace

TEST_CASE(
    "sheets thrown at each other at any speed end without intersection, with the same bits on any "
    "team") {
  const TestScene scene = facing_sheets();
  REQUIRE(intersecting_pairs(scene.x, scene.model.triangles).empty());
  const Index n = scene.model.surfaces[0].n_vertices;
  for (const double travel : {0.03, 0.5}) {
    Points thrown = shaken(scene.x, 0.3 * travel, 16);
    thrown.topRows(n).col(2).array() += travel;
    thrown.bottomRows(scene.x.rows() - n).col(2).array() -= travel;
    REQUIRE(!intersecting_pairs(thrown, scene.model.triangles).empty());
    Points first;
    for (const int threads : {1, 2, 3, 7}) {
      CollisionStage stage(scene.model);
      if (threads == 3) stage.proximity(Team{threads}, scene.x, {});  // builds neighbour lists
      Points x1 = thrown;
      const CertifyReport report =
          stage.certify(Team{threads}, {scene.x, scene.inverse_mass, {}}, x1, none);
      CHECK(report.impacts > 100);
      CHECK(report.unresolved == 0);
      if (threads == 1) {
        first = x1;
        CHECK(intersecting_pairs(x1, scene.model.triangles).empty());
      }
      CHECK(x1 == first);
    }
  }
}

TEST_CASE("many random steps with impacts never end in an intersection") {
  TestScene scene = facing_sheets();
  CollisionStage stage(scene.model);
  Points x = scene.x;
  for (int step = 0; step < 12; ++step) {
    stage.proximity(Team{2}, x, {});
    Points x1 = shaken(x, step % 3 ? 3e-3 : 0.02, 17 + step);
    const CertifyReport report = stage.certify(Team{2}, {x, scene.inverse_mass, {}}, x1, none);
    CHECK(report.unresolved == 0);
    x = x1;
    REQUIRE(intersecting_pairs(x, scene.model.triangles).empty());
  }
}

TEST_CASE("a motion without impact is not changed") {
  const TestScene scene = facing_sheets();
  CollisionStage stage(scene.model);
  const Points given = shaken(scene.x, 2e-4, 18);
  Points x1 = given;
  const CertifyReport report = stage.certify(Team{1}, {scene.x, scene.inverse_mass, {}}, x1, none);
  CHECK(report.impacts == 0);
  CHECK(x1 == given);
}

TEST_CASE("a fast obstacle carries cloth along and keeps its own motion to the last bit") {
  for (const bool turning : {false, true}) {
    const TestScene scene =
        make_scene({{grid_cells(0.2, 0.2, 16, 16), Kind::Cloth, 2e-3},
                    {icosphere(0.04, 2).moved(Vec3(0.003, 0.002, 0.045)), Kind::Script, 2e-3}});
    const CollisionSurface& sphere = scene.model.surfaces[1];
    Points given = shaken(scene.x, 1e-3, 19);
    const Eigen::Matrix3d rotation = (turning ? Eigen::AngleAxisd(0.8, Vec3(1, 2, 3).normalized())
                                              : Eigen::AngleAxisd(0.0, Vec3::UnitX()))
                                         .toRotationMatrix();
    for (Index i = 0; i < sphere.n_vertices; ++i) {
      const Vec3 arm = scene.x.row(sphere.first_vertex + i).transpose() - Vec3(0.003, 0.002, 0.045);
      given.row(sphere.first_vertex + i) = (Vec3(0.003, 0.002, -0.2) + rotation * arm).transpose();
    }
    CollisionStage stage(scene.model);
    Points x1 = given;
    const CertifyReport report =
        stage.certify(Team{2}, {scene.x, scene.inverse_mass, {}}, x1, none);
    CHECK(report.impacts > 0);
    CHECK(report.unresolved == 0);
    CHECK(intersecting_pairs(x1, scene.model.triangles).empty());
    for (Index i = 0; i < sphere.n_vertices; ++i)
      CHECK(x1.row(sphere.first_vertex + i) == given.row(sphere.first_vertex + i));
    // The sphere of radius 0.04 m has pushed the sheet down to the level of the sphere's bottom.
    CHECK(x1.topRows(scene.model.surfaces[0].n_vertices).col(2).minCoeff() < -0.2 - 0.039);
  }
}

TEST_CASE("cloth between obstacles that pass through each other is reported as unresolved") {
  const TestScene scene =
      make_scene({{grid_cells(0.1, 0.1, 8, 8), Kind::Cloth, 2e-3},
                  {floor_square(0.3, 2).moved(Vec3(0.001, 0.002, 0.01)), Kind::Script, 2e-3},
                  {floor_square(0.3, 2).moved(Vec3(0.003, 0.001, -0.01)), Kind::Script, 2e-3}});
  Points given = scene.x;
  const CollisionSurface &upper = scene.model.surfaces[1], &lower = scene.model.surfaces[2];
  given.middleRows(upper.first_vertex, upper.n_vertices).col(2).array() -= 0.05;
  given.middleRows(lower.first_vertex, lower.n_vertices).col(2).array() += 0.05;
  CollisionStage stage(scene.model);
  Points x1 = given;
  CHECK(stage.certify(Team{1}, {scene.x, scene.inverse_mass, {}}, x1, none).unresolved > 0);
}

TEST_CASE(
    "prescribed vertices keep their motion, and the cloth they drag stays free of intersections") {
  TestScene scene = facing_sheets();
  Points given = scene.x;
  for (Index v = 0; v < 17; ++v) {  // moves a border of the lower sheet through the upper one
    scene.inverse_mass[v] = 0.0;
    given(v, 2) += 0.06;
  }
  CollisionStage stage(scene.model);
  Points x1 = given;
  const CertifyReport report = stage.certify(Team{1}, {scene.x, scene.inverse_mass, {}}, x1, none);
  CHECK(report.impacts > 0);
  CHECK(report.unresolved == 0);
  CHECK(x1.topRows(17) == given.topRows(17));
  CHECK(intersecting_pairs(x1, scene.model.triangles).empty());
}

TEST_CASE("cloth that starts tangled neither fails nor gets stuck") {
  const TestScene scene = make_scene(
      {{grid_cells(0.1, 0.1, 8, 8), Kind::Cloth, 2e-3},
       {grid_cells(0.1, 0.1, 8, 8)
            .moved(Vec3(0.003, 0.002, 0), Eigen::AngleAxisd(0.3, Vec3::UnitX()).toRotationMatrix()),
        Kind::Cloth, 2e-3}});
  REQUIRE(!intersecting_pairs(scene.x, scene.model.triangles).empty());
  CollisionStage stage(scene.model);
  Points x = scene.x;
  const Index n = scene.model.surfaces[0].n_vertices;
  for (int step = 0; step < 60; ++step) {
    Points x1 = x;
    x1.topRows(n).col(0).array() += 3e-3;  // moves the first sheet sideways
    stage.certify(Team{1}, {x, scene.inverse_mass, {}}, x1, none);
    x = x1;
  }
  CHECK(x.topRows(n).col(0).mean() > 0.02);
}
