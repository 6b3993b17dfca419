// Tests of tangles: the edges that pierce triangles, the directions in which these edges move back,
// and the retraction of surfaces that cross from edge to edge.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <set>

#include "core/collision/narrow_phase/exact_predicates.h"
#include "core/collision/response/untangling.h"
#include "core/collision/tangle/tangle.h"
#include "tests/collision/collision_scenes.h"
#include "tests/support/shaped.h"

using namespace loomstone;

namespace {

// A flat sheet, and a sheet with a bump that passes up through the flat one. If `moved` is 0, edges
// of one sheet lie exactly above or below edges of the other.
TestScene bump(double moved) {
  const TriangleMesh flat = grid_cells(0.2, 0.2, 12, 12);
  return make_scene(
      {{flat}, {test::shaped(flat.moved(Vec3(moved, 0.7 * moved, 0)), [](double x, double y) {
         const double dx = x - 0.003, dy = y + 0.004;
         return -0.01 + 0.03 * std::exp(-(dx * dx + dy * dy) / 0.0009);
       })}});
}

// A flat sheet, and a tilted sheet that cuts through the flat one. The contour of the intersection
// runs from border to border of the tilted sheet.
TestScene leaning() {
  const TriangleMesh flat = grid_cells(0.2, 0.2, 12, 12);
  return make_scene({{flat},
                     {test::shaped(grid_cells(0.15, 0.15, 10, 10).moved(Vec3(0.011, 0.007, 0)),
                                   [](double x, double y) { return 0.5 * (x + y) + 0.04; })}});
}

// Two sheets of the same size. The contour of their intersection enters each sheet at a border, and
// neither sheet is cut in two.
TestScene crossed(int cells, double degrees) {
  const TriangleMesh flat = grid_cells(0.2, 0.2, cells, cells);
  const Mat3 turn =
      Eigen::AngleAxisd(degrees * std::numbers::pi / 180.0, Vec3::UnitY()).toRotationMatrix();
  return make_scene({{flat}, {flat.moved(Vec3(0.02, 0.0031, 0.01), turn)}});
}

}  // namespace

TEST_CASE("every edge that pierces a triangle is found, with the point both share") {
  for (const TestScene& scene : {bump(0.0013), leaning()}) {
    const CollisionModel& model = scene.model;
    const Tangle tangle = TangleFinder(model).find(scene.x);
    std::set<std::array<Index, 2>> expected, found;
    const auto x = [&](Index v) { return Vec3(scene.x.row(v).transpose()); };
    for (Index e = 0; e < model.edges.rows(); ++e)
      for (Index t = 0; t < model.triangles.rows(); ++t) {
        const Index p = model.edges(e, 0), q = model.edges(e, 1);
        const auto corner = model.triangles.row(t);
        if ((corner.array() == p).any() || (corner.array() == q).any()) continue;
        const Vec3 a = x(corner[0]), b = x(corner[1]), c = x(corner[2]);
        if (orientation(a, b, c, x(p)) * orientation(a, b, c, x(q)) >= 0) continue;
        const int left = orientation(x(p), x(q), a, b);
        if (left != 0 && left == orientation(x(p), x(q), b, c) &&
            left == orientation(x(p), x(q), c, a))
          expected.insert({e, t});
      }
    REQUIRE(expected.size() > 20);
    for (const Piercing& p : tangle.piercings) {
      found.insert({p.edge, p.triangle});
      Vec3 apart = Vec3::Zero();
      double of_edge = 0.0, of_triangle = 0.0;
      for (int k = 0; k < 5; ++k) {
        apart += p.weights[k] * x(p.vertices[k]);
        (k < 2 ? of_edge : of_triangle) += p.weights[k];
      }
      CHECK(apart.norm() < 1e-14);  // rounding of coordinates of 0.1 m
      CHECK(of_edge == Approx(1.0).epsilon(1e-14));
      CHECK(of_triangle == Approx(-1.0).epsilon(1e-14));
      CHECK(p.contour == tangle.piercings.front().contour);
    }
    CHECK(found == expected);
  }
}

TEST_CASE("untangling moves vertices back the way they came") {
  for (const TestScene& scene : {bump(0.0), bump(0.0013), leaning()}) {
    const Index n_flat = scene.model.surfaces[0].n_vertices;
    const Tangle tangle = TangleFinder(scene.model).find(scene.x);
    int of_bent = 0;
    for (const Piercing& p : tangle.piercings) {
      if (p.vertices[0] < n_flat) continue;
      ++of_bent;
      // The bump leaves the flat sheet downwards. The tilted sheet leaves the flat sheet upwards,
      // because the smaller part of the tilted sheet hangs below.
      const bool is_bump = n_flat == scene.model.surfaces[1].n_vertices;
      CHECK(p.way_out.z() == Approx(is_bump ? -1.0 : 1.0));
    }
    CHECK(of_bent > 10);
  }
}

TEST_CASE("surfaces that do not intersect are not tangled, nor is one without self-collision") {
  TestScene scene = bump(0.0);
  TangleFinder finder(scene.model);
  Points apart = scene.x;
  apart.bottomRows(scene.model.surfaces[1].n_vertices).col(2).array() -= 0.021;
  const Tangle none = finder.find(apart);
  CHECK(none.empty());
  CHECK_FALSE(
      none.ignores(scene.model, ContactKind::VertexFace, pair_key(0, 300), {0, 169, 170, 171}));

  // Treats both sheets as one surface; self-intersections count only with self-collision.
  std::vector<CollisionSurface>& surfaces = scene.model.surfaces;
  surfaces[0].n_vertices += surfaces[1].n_vertices;
  surfaces[0].n_triangles += surfaces[1].n_triangles;
  surfaces.pop_back();
  CHECK_FALSE(finder.find(scene.x).empty());
  surfaces[0].self_collision = false;
  CHECK(finder.find(scene.x).empty());
}

TEST_CASE("terms and impulses that untangle have neither sum nor torque") {
  const TestScene scene = bump(0.0013);
  const Index n = scene.model.n_vertices;
  const Tangle tangle = TangleFinder(scene.model).find(scene.x);
  ExtraTerms terms;
  const Points still = Points::Zero(n, 3);
  const Points no_bodies(0, 3);
  untangling_terms(scene.model, tangle,
                   {scene.x, still, still, no_bodies, 1e-3, n, scene.inverse_mass, Points(0, 3)},
                   terms);
  REQUIRE(terms.size() > 20);
  Vec3 sum = Vec3::Zero(), torque = Vec3::Zero();
  double size = 0.0;
  for (const ExtraTerm& term : terms)
    for (int e = 0; e < term.n_entries; ++e) {
      const Vec3 force = -term.entries[e].apply_transposed(term.gradient);
      sum += force;
      torque += Vec3(scene.x.row(term.entries[e].row).transpose()).cross(force);
      size += force.norm();
    }
  CHECK(size > 1.0);
  CHECK(sum.norm() < 1e-13 * size);
  CHECK(torque.norm() < 1e-13 * size);  // rounding of torques with lever arms of 0.1 m

  FreeBodies none;
  Impulses impulses(scene.model, scene.inverse_mass, none);
  std::vector<ImpulseContact> all =
      untangling_impulses(tangle, {}, impulses, scene.x, scene.x, 1e-3);
  REQUIRE(all.size() == tangle.piercings.size());
  for (ImpulseContact& c : all) c.scale = c.largest_change;
  Points x1 = scene.x;
  impulses.solve(all, scene.x, x1, 30, 1e-4);
  sum.setZero();
  torque.setZero();
  size = 0.0;
  for (Index i = 0; i < n; ++i) {
    const Vec3 moved = (x1.row(i) - scene.x.row(i)).transpose();
    sum += moved;
    torque += Vec3(scene.x.row(i).transpose()).cross(moved);
    size += moved.norm();
  }
  CHECK(size > 1e-3);
  // The tolerance covers rounding: displacements of 1e-4 m are differences of coordinates of 0.1 m.
  CHECK(sum.norm() < 1e-12 * size);
  CHECK(torque.norm() < 1e-12 * size);
}

TEST_CASE("sheets that cross from edge to edge retract, the smaller part first") {
  for (const int cells : {9, 15, 30})
    for (const double degrees : {25.0, 90.0, 140.0}) {
      INFO(cells << " cells, " << degrees << " degrees");
      const TestScene scene = crossed(cells, degrees);
      const Tangle tangle = TangleFinder(scene.model).find(scene.x);
      REQUIRE(tangle.retractions.size() == 1);
      const Retraction& retraction = tangle.retractions[0];
      // The sheets intersect along the line x = at, z = 0. Extended to the borders, this line
      // divides each sheet in two. The sheet with the smallest of the four parts retracts. The
      // expected depth is the width of this part.
      const double at = 0.02 + 0.01 / std::tan(degrees * std::numbers::pi / 180.0);
      const double half_width = 0.1 - 0.01 / std::sin(degrees * std::numbers::pi / 180.0);
      CHECK(std::abs(retraction.point.x() - at) < 1e-9);
      // The line is extended along mesh edges, so the tolerance is one edge length.
      CHECK(std::abs(retraction.depth - std::min(0.1 - std::abs(at), half_width)) < 0.2 / cells);
      int inner = 0;
      for (std::size_t v = 0; v < tangle.came_through.size(); ++v) inner += tangle.came_through[v];
      const double share = static_cast<double>(inner) / retraction.inner.size();
      CHECK(std::abs(share - retraction.depth / 0.2) < 1.0 / cells);
    }
}

TEST_CASE("surfaces retract without changing momentum and angular momentum") {
  const TestScene scene = crossed(15, 70.0);
  const Index n = scene.model.n_vertices;
  const Tangle tangle = TangleFinder(scene.model).find(scene.x);
  const Points still = Points::Zero(n, 3);
  const RetractedMotion motion =
      retracted_motion(scene.model, tangle, scene.inverse_mass, scene.x, still, 1e-3);
  REQUIRE(motion.acceleration.rows() == n);
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
  double size = 0.0;
  for (Index i = 0; i < n; ++i) {
    const Vec3 f = motion.acceleration.row(i).transpose() / scene.inverse_mass[i];
    force += f;
    torque += Vec3(scene.x.row(i).transpose()).cross(f);
    size += f.norm();
  }
  CHECK(size > 1.0);
  CHECK(force.norm() < 1e-13 * size);
  CHECK(torque.norm() < 1e-13 * size);  // rounding of torques with lever arms of 0.1 m
  // At each point where an edge of the retracting sheet pierces the other sheet, this edge moves
  // away from the other sheet in the direction of the retraction.
  const Retraction& retraction = tangle.retractions[0];
  for (const Piercing& p : tangle.piercings) {
    if (!std::binary_search(retraction.inner.begin(), retraction.inner.end(), p.vertices[0]))
      continue;
    Vec3 apart = Vec3::Zero();
    for (int k = 0; k < 5; ++k)
      apart += p.weights[k] * motion.velocity.row(p.vertices[k]).transpose();
    CHECK(apart.dot(retraction.direction) > 0.9 * 15.0 * 1e-3);  // 15 m/s^2 for 1 ms
  }
}

TEST_CASE("a surface that takes part in several retractions moves with their sum") {
  const TriangleMesh flat = grid_cells(0.2, 0.2, 15, 15);
  const auto tilted = [&](double x, double degrees) {
    const Mat3 turn =
        Eigen::AngleAxisd(degrees * std::numbers::pi / 180.0, Vec3::UnitY()).toRotationMatrix();
    return flat.moved(Vec3(x, 0.0031, 0.01), turn);
  };
  const TestScene scene = make_scene({{flat}, {tilted(0.05, 70.0)}, {tilted(-0.06, 110.0)}});
  const Tangle tangle = TangleFinder(scene.model).find(scene.x);
  REQUIRE(tangle.retractions.size() == 2);
  const double step = 1e-3;
  const Points steady = Vec3(0.1, -0.2, 0.05).transpose().replicate(scene.model.n_vertices, 1);
  const auto motion = [&](std::vector<Retraction> retractions) {
    Tangle part = tangle;
    part.retractions = std::move(retractions);
    return retracted_motion(scene.model, part, scene.inverse_mass, scene.x, steady, step);
  };
  const RetractedMotion both = motion(tangle.retractions), first = motion({tangle.retractions[0]}),
                        second = motion({tangle.retractions[1]});
  const Index flat_vertices = flat.n_vertices();
  for (const RetractedMotion* alone : {&first, &second})
    REQUIRE(alone->acceleration.topRows(flat_vertices).rowwise().norm().minCoeff() > 0.1);
  const double size = both.acceleration.norm();
  CHECK((both.acceleration - first.acceleration - second.acceleration).norm() < 1e-14 * size);
  CHECK((both.velocity - steady - step * both.acceleration).norm() < 1e-12 * step * size);
}

TEST_CASE("a cloth with a board through its middle is not pulled to both sides") {
  const TriangleMesh flat = grid_cells(0.2, 0.2, 15, 15);
  const TriangleMesh board = box(0.003, 0.3, 0.3);
  const TestScene scene = make_scene({{flat}, {board, CollisionSurface::Kind::Script}});
  const Tangle tangle = TangleFinder(scene.model).find(scene.x);
  REQUIRE(tangle.piercings.size() > 20);
  CHECK(tangle.retractions.empty());
  for (const Piercing& p : tangle.piercings) CHECK(p.way_out.isZero(0.0));
}
