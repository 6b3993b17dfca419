#include <catch2/catch.hpp>

#include "core/collision/collision_stage.h"
#include "tests/collision/collision_scenes.h"

using namespace loomstone;
using Kind = CollisionSurface::Kind;

namespace {

FreeBodies none;

// Two sheets closer than their thickness, with 1 g per vertex.
TestScene close_sheets(double friction) {
  return make_scene({{grid_cells(0.1, 0.1, 8, 8), Kind::Cloth, 2e-3, friction},
                     {jittered_grid(0.1, 0.1, 7, 7, 0.2, 3).moved(Vec3(4e-3, 1e-3, 1.2e-3)),
                      Kind::Cloth, 2e-3, friction}});
}

Vec3 angular(const Points& x, const Points& change) {
  Vec3 sum = Vec3::Zero();
  for (Index v = 0; v < x.rows(); ++v)
    sum += Vec3(x.row(v).transpose()).cross(Vec3(change.row(v).transpose()));
  return sum;
}

struct GapsOfSlide {
  double distance, speed, smallest_gap, largest_gap;
};
// Moves the vertices of a sheet on a floor by symplectic Euler, with tilted gravity and repelling
// impulses but without elastic forces. Returns the distance along x [m] and the final speed
// [m/s] of one vertex, and the smallest and largest gap of all vertices in all steps [m].
GapsOfSlide gaps_of_slide(double slope, double h, double duration) {
  TestScene scene = make_scene(
      {{grid_cells(0.02, 0.02, 2, 2).moved(Vec3(0.003, 0.002, 1e-3)), Kind::Cloth, 1e-3, 0.3},
       {floor_square(2.0, 3), Kind::Script, 1e-3, 0.3}});
  const Index n = scene.model.surfaces[0].n_vertices;
  CollisionStage stage(scene.model);
  const Eigen::RowVector3d gravity =
      9.81 * Eigen::RowVector3d(std::sin(std::atan(slope)), 0, -std::cos(std::atan(slope)));
  Points x = scene.x, v = Points::Zero(x.rows(), 3);
  GapsOfSlide result{0.0, 0.0, 1.0, 0.0};
  for (int step = 0; step < duration / h; ++step) {
    const auto contacts = stage.proximity(Team{1}, x, {});
    v.topRows(n).rowwise() += h * gravity;
    Points x1 = x + h * v;
    stage.repel({x, scene.inverse_mass, {}}, contacts, h, x1, none);
    v = (x1 - x) / h;
    x = x1;
    result.smallest_gap = std::min(result.smallest_gap, x.topRows(n).col(2).minCoeff());
    result.largest_gap = std::max(result.largest_gap, x.topRows(n).col(2).maxCoeff());
  }
  result.distance = x(0, 0) - scene.x(0, 0);
  result.speed = v.row(0).norm();
  return result;
}

}  // namespace

TEST_CASE(
    "repelling impulses conserve linear momentum, and without friction angular momentum, to "
    "rounding") {
  for (const double friction : {0.0, 0.5}) {
    const TestScene scene = close_sheets(friction);
    CollisionStage stage(scene.model);
    const auto contacts = stage.proximity(Team{1}, scene.x, {});
    REQUIRE(contacts.size() > 100);
    Points thrown = shaken(scene.x, 2e-4, 7);
    const Index n = scene.model.surfaces[0].n_vertices;
    thrown.topRows(n).rowwise() += Eigen::RowVector3d(1e-3, 0, 5e-4);
    Points x1 = thrown;
    stage.repel({scene.x, scene.inverse_mass, {}}, contacts, 1e-3, x1, none);
    const Points change = x1 - thrown;
    const double size = change.rowwise().norm().sum();  // measures the impulses
    CHECK(size > 1e-3);
    CHECK(change.colwise().sum().norm() < 1e-14);  // 145 coordinates of 0.1 m, rounded to 1e-17 m
    const double turned = angular(scene.x, change).norm();
    if (friction == 0.0)
      CHECK(turned < 1e-14);
    else
      CHECK(turned < 2e-3 * size);  // torque of friction: at most thickness times impulse
    // After the impulses, no pair in contact approaches by more than 5 % of the 0.5 mm by which the
    // lower sheet is thrown towards the upper one.
    for (const Contact& contact : contacts) {
      double approach = 0.0;
      for (int i = 0; i < 4; ++i)
        approach +=
            contact.weights[i] *
            contact.normal.dot(
                (x1.row(contact.vertices[i]) - scene.x.row(contact.vertices[i])).transpose());
      CHECK(approach > -0.05 * 5e-4);
    }
  }
}

TEST_CASE("repulsion pushes a free body and the cloth apart") {
  const Vec3 centre(0.003, 0.002, 0.041);
  TestScene scene = make_scene({{grid_cells(0.1, 0.1, 16, 16), Kind::Cloth, 2e-3},
                                {icosphere(0.04, 3).moved(centre), Kind::Body, 2e-3}});
  const CollisionSurface& surface = scene.model.surfaces[1];
  const Points local =
      scene.x.middleRows(surface.first_vertex, surface.n_vertices).rowwise() - centre.transpose();
  FreeBody body;
  body.surface = 1;
  body.local = &local;
  body.inverse_mass = 1.0 / 0.05;
  body.inverse_inertia = Mat3::Identity() / (0.4 * 0.05 * 0.04 * 0.04);
  body.start.position = centre;
  body.end.position = centre + Vec3(2e-4, 0, -1e-3);
  FreeBodies bodies = {body};
  Points thrown = scene.x;
  place_body(scene.model, body, body.end, thrown);
  CollisionStage stage(scene.model);
  const auto contacts = stage.proximity(Team{1}, scene.x, {});
  REQUIRE(!contacts.empty());
  Points x1 = thrown;
  stage.repel({scene.x, scene.inverse_mass, {}}, contacts, 1e-3, x1, bodies);
  Vec3 change = 0.05 * bodies[0].moved;
  for (Index v = 0; v < surface.first_vertex; ++v)
    change += (x1.row(v) - thrown.row(v)).transpose() / 1e3;
  CHECK(bodies[0].moved.z() > 0.0);
  CHECK(bodies[0].turned.y() > 0.0);  // friction from below makes the moving ball roll
  CHECK(change.norm() < 1e-12 * 0.05 * bodies[0].moved.norm() + 1e-17);
}

TEST_CASE(
    "impulses keep the thickness as gap, stick below the friction angle and slide by Coulomb's law "
    "above it") {
  for (const double h : {1e-3, 1e-4}) {
    const GapsOfSlide held = gaps_of_slide(0.295, h, 0.5), sliding = gaps_of_slide(0.305, h, 0.5),
                      fast = gaps_of_slide(0.5, h, 0.5);
    // Without friction, the cloth would slide 0.35 m. With friction, it creeps a little, because
    // the sweeps stop when corrections are below 1e-4 of the motion in a step.
    CHECK(held.distance < 1e-6);
    for (const GapsOfSlide& each : {held, sliding, fast}) {
      CHECK(each.smallest_gap > 0.99e-3);
      CHECK(each.largest_gap <= 1e-3);
    }
    const auto exact = [&](double slope) {  // distance of symplectic Euler: a t (t + h) / 2
      const double angle = std::atan(slope);
      return 0.5 * 9.81 * (std::sin(angle) - 0.3 * std::cos(angle)) * 0.5 * (0.5 + h);
    };
    CHECK(sliding.distance == Approx(exact(0.305)).epsilon(5e-3));
    CHECK(fast.distance == Approx(exact(0.5)).epsilon(5e-3));
  }
}
