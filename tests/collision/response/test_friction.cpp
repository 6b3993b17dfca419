#include <catch2/catch.hpp>

#include <cmath>

#include "core/collision/collision_stage.h"
#include "core/collision/response/friction.h"
#include "tests/collision/collision_scenes.h"

using namespace loomstone;
using Kind = CollisionSurface::Kind;

namespace {

struct Slide {
  double distance, speed;
};
// Moves a small sheet as a rigid block on a floor under tilted gravity. Returns the distance along
// x [m] and the final speed [m/s]. The vertices of the sheet have a common velocity, computed by
// semi-implicit Euler. At the start, vertex contacts carry the weight of the block. Each has the
// force 2 k depth^2 / xi at the gap xi - depth, with the contact stiffness k and the thickness xi.
Slide slide(double slope, double duration, double floor_speed = 0.0, double h = 1e-3,
            bool again = true) {
  const double thickness = 1e-3;
  TestScene scene = make_scene({{grid_cells(0.02, 0.02, 2, 2).moved(Vec3(0.003, 0.002, thickness)),
                                 Kind::Cloth, thickness, 0.3},
                                {floor_square(1.0, 3), Kind::Script, thickness, 0.3}});
  const Index n = scene.model.surfaces[0].n_vertices;
  CollisionStage stage(scene.model);
  ContactState state;
  const double mass = 1e-3;
  const Vec3 gravity = 9.81 * Vec3(std::sin(std::atan(slope)), 0, -std::cos(std::atan(slope)));
  const double weight = -mass * gravity.z();
  const double depth = std::sqrt(0.5 * weight * thickness /
                                 (static_cast<double>(n) * scene.model.contact_stiffness));
  scene.x.topRows(n).col(2).array() -= depth;
  Points x = scene.x, v = Points::Zero(x.rows(), 3);
  v.bottomRows(x.rows() - n).col(0).setConstant(floor_speed);
  Vec3 velocity = Vec3(floor_speed, 0, 0);
  Points last_change = Points::Zero(x.rows(), 3);
  for (int step = 0; step < duration / h; ++step) {
    v.topRows(n).rowwise() = velocity.transpose();
    const auto contacts = stage.proximity(Team{1}, x, {});
    ExtraTerms terms;
    const ContactTerms made =
        stage.terms({}, {x, v, last_change, Points(0, 3), h, n, scene.inverse_mass, Points(0, 3)},
                    contacts, state, terms);
    const Vec3 before = velocity;
    // If `again` is true, up to two more solves correct the contact forces, as in the linearised
    // integrators.
    for (int solve = 0; solve < 3; ++solve) {
      Mat3 matrix = mass * Mat3::Identity();
      Vec3 right = mass * before + h * mass * gravity;
      for (const ExtraTerm& term : terms) {
        double sum = 0.0;  // sum of the barycentric weights of the cloth vertices
        for (int i = 0; i < term.n_entries; ++i) sum += term.entries[i].weight;
        matrix += h * h * sum * sum * term.hessian;
        right -= h * sum * (term.gradient - h * term.hessian * term.drift);
      }
      velocity = matrix.ldlt().solve(right);
      if (!again || terms.empty()) break;
      const Points moved = h * velocity.transpose().replicate(n, 1);
      const Vector inverse_mass = Vector::Constant(n, static_cast<double>(n) / mass);
      if (made.forces_after(Team{1}, moved, h, inverse_mass, false, terms).relative(false) < 0.02)
        break;
    }
    last_change.topRows(n).rowwise() = (velocity - before).transpose();
    Points x1 = x + h * v;
    x1.topRows(n) = x.topRows(n).rowwise() + h * velocity.transpose();
    stage.update_anchors(contacts, made, x, x1, state);
    x = x1;
  }
  return {x(0, 0) - scene.x(0, 0), velocity.norm()};
}

}  // namespace

TEST_CASE(
    "friction is a spring force inside the cone and lies on the cone otherwise, and its stiffness "
    "is positive") {
  const Mat3 tangent = Vec3(1, 1, 0).asDiagonal();
  const FrictionResponse sticking =
      friction_response(Vec3(1e-4, 0, 0), Vec3(1e-4, 0, 0), tangent, 100.0, 0.03);
  CHECK(sticking.gradient == Vec3(1e-4 * 100.0, 0, 0));
  CHECK(sticking.hessian == 100.0 * tangent);
  const Vec3 s(1e-4, 2e-4, 0), u(9e-4, -1e-4, 0);
  const FrictionResponse slipping = friction_response(s, u, tangent, 100.0, 0.03);
  // With the displacement u predicted for the step, the slip s becomes s + u. The force then lies
  // on the friction cone in the direction of s + u.
  CHECK((slipping.gradient + slipping.hessian * u).norm() == Approx(0.03));
  CHECK((slipping.gradient + slipping.hessian * u).normalized().dot((s + u).normalized()) ==
        Approx(1.0));
  CHECK(slip_after(s, u, 100.0, 0.03).norm() == Approx(0.03 / 100.0));
  // Without friction, there is no stiffness.
  CHECK(friction_response(Vec3::Zero(), Vec3::Zero(), tangent, 100.0, 0.0).hessian.isZero(0.0));
}

TEST_CASE("a block on a slope sticks below the friction angle and slides above it") {
  const Slide held = slide(0.295, 2.0), sliding = slide(0.305, 2.0);
  CHECK(held.speed < 1e-6);
  CHECK(held.distance < 2e-4);  // only the elastic displacement of the friction springs
  CHECK(sliding.speed > 0.05);
  CHECK(sliding.distance > 0.05);
}

TEST_CASE("long slides follow Coulomb's law at every slope above the friction angle") {
  // Even without friction, steps of h = 4 ms overestimate the distance after a time t by the
  // fraction h / t, which is below 1 %. The tolerances of 2 and 4 % allow for this error. At slope
  // 0.305 the net force is only 1.7 % of the friction, so an error of 0.07 % in the friction
  // changes the distance by 4 %. Each step therefore repeats its solve with the slip of this step.
  // With the slip of the previous step, friction would be too large by the fraction h / t.
  for (const double h : {1e-3, 4e-3})
    for (const double slope : {0.305, 0.35, 0.5}) {
      const double angle = std::atan(slope),
                   pull = 9.81 * (std::sin(angle) - 0.3 * std::cos(angle));
      // Distance in 2 s, but at most 0.3 m.
      const double distance = std::min(0.3, 0.5 * pull * 4.0);
      INFO("step " << h << " slope " << slope);
      CHECK(slide(slope, std::sqrt(2.0 * distance / pull), 0.0, h).distance ==
            Approx(distance).epsilon(slope < 0.31 ? 0.04 : 0.02));
    }
  // A single solve per step, with the extrapolated slip, is accurate to 3 %.
  CHECK(slide(0.5, 0.5, 0.0, 1e-3, false).distance ==
        Approx(0.5 * 9.81 * 0.2 / std::sqrt(1.25) * 0.25).epsilon(0.03));
}

TEST_CASE("the predicted slip grows by its last gain, never shrinks and at most doubles") {
  const Vec3 s(1e-4, 0, 0), u(2e-4, 0, 0);
  CHECK(sped_up(s, u, Vec3(5e-5, 3e-5, 0), 1000.0, 0.1) == Vec3(2.5e-4, 0, 0));
  CHECK(sped_up(s, u, Vec3(9e-4, 0, 0), 1000.0, 0.1) == Vec3(4e-4, 0, 0));
  CHECK(sped_up(s, u, Vec3(-9e-5, 0, 0), 1000.0, 0.1) == u);   // the slip decelerates
  CHECK(sped_up(s, u, Vec3(5e-5, 0, 0), 1000.0, 0.4) == u);    // the contact sticks
  CHECK(sped_up(-s, u, Vec3(5e-5, 0, 0), 1000.0, 0.01) == u);  // the slip reverses
}

TEST_CASE("a moving floor carries a block along") {
  // Floor and block both move at 0.1 m/s.
  const Slide carried = slide(0.0, 1.0, 0.1);
  CHECK(carried.distance == Approx(0.1).epsilon(1e-6));
}

TEST_CASE("an anchor follows a vertex to a neighbouring face and ends with its contact") {
  TestScene scene =
      make_scene({{grid_cells(0.2, 0.2, 1, 1).moved(Vec3(0, 0, 0.5e-3)), Kind::Cloth, 1e-3},
                  {grid_cells(0.1, 0.1, 4, 4), Kind::Script, 1e-3}});
  CollisionStage stage(scene.model);
  Points x = scene.x;
  x.middleRows(1, 3).col(2).array() += 1.0;
  x.row(0) = Eigen::RowVector3d(0.004, 0.010, 0.5e-3);
  const auto first = stage.proximity(Team{1}, x, {});
  REQUIRE(first.size() == 1);
  Points x1 = x;
  x1(0, 0) += 2e-5;
  ContactState state;
  ExtraTerms terms;
  const Points still = Points::Zero(x.rows(), 3);
  const ContactTerms made =
      stage.terms({}, {x, still, still, Points(0, 3), 1e-3, 4, scene.inverse_mass, Points(0, 3)},
                  first, state, terms);
  stage.update_anchors(first, made, x, x1, state);
  REQUIRE(state.anchors.size() == 1);
  CHECK((state.anchors[0].slip - Vec3(2e-5, 0, 0)).norm() < 1e-15);
  x1.row(0) = Eigen::RowVector3d(0.010, 0.004, 0.5e-3);  // the vertex moves across the diagonal
  const auto second = stage.proximity(Team{1}, x1, {});
  REQUIRE(second.size() == 1);
  CHECK(second[0].b != first[0].b);
  CHECK((anchored_slips(second, scene.model, state)[0] - Vec3(2e-5, 0, 0)).norm() < 1e-15);
  stage.update_anchors({}, {}, x1, x1, state);
  CHECK(state.anchors.empty());
}

TEST_CASE("friction that is too large on balance is an error of its own") {
  ContactError error;
  const auto add = [&](double excess) {
    error.sums[ContactError::Wrong].add(std::abs(excess));
    error.sums[ContactError::Excess].add(excess);
    error.sums[ContactError::Limit].add(1.0);
  };
  // Errors of opposite signs cancel, and friction that is too small is no excess.
  add(0.5), add(-0.75);
  CHECK(error.relative(false) == 1.25 / 2.0);
  CHECK(error.relative(true) == 1.25 / 2.0);
  // The excess counts ten times.
  add(0.75);
  CHECK(error.relative(false) == 2.0 / 3.0);
  CHECK(error.relative(true) == 10.0 * (0.5 / 3.0));
}

TEST_CASE("friction has an excess if it takes more energy than Coulomb's law") {
  const double thickness = 1e-3, h = 1e-3;
  TestScene scene =
      make_scene({{grid_cells(0.02, 0.02, 2, 2).moved(Vec3(0.003, 0.002, 0.9 * thickness)),
                   Kind::Cloth, thickness, 0.3},
                  {floor_square(1.0, 3), Kind::Script, thickness, 0.3}});
  const Index n = scene.model.surfaces[0].n_vertices;
  const Points still = Points::Zero(scene.x.rows(), 3);
  CollisionStage stage(scene.model);
  const auto contacts = stage.proximity(Team{1}, scene.x, {});
  // Returns the sum of a ContactError if the sheet is predicted to slide by `predicted` and slides
  // by `done` [m] along x.
  const auto error = [&](double predicted, double done, int sum) {
    Points v = still;
    v.topRows(n).col(0).setConstant(predicted / h);
    ExtraTerms terms;
    const ContactTerms made =
        stage.terms({}, {scene.x, v, still, Points(0, 3), h, n, scene.inverse_mass, Points(0, 3)},
                    contacts, {}, terms);
    Points moved = Points::Zero(n, 3);
    moved.col(0).setConstant(done);
    return made.forces_after(Team{1}, moved, h, scene.inverse_mass, false, terms).sums[sum].value();
  };
  const double slid = 1e-3;  // far beyond the slip at which contacts begin to slide
  const double limit = error(slid, slid, ContactError::Limit);
  REQUIRE(limit > 0.0);
  // The secant stiffness is proportional to 1 / predicted, so friction is the limit times
  // done / predicted, in either direction.
  for (const double sign : {1.0, -1.0}) {
    const auto excess = [&](double predicted) {
      return error(sign * predicted, sign * slid, ContactError::Excess) / limit;
    };
    CHECK(excess(slid) == Approx(0.0).margin(1e-9));
    CHECK(excess(0.8 * slid) == Approx(0.25).epsilon(1e-3));
    CHECK(excess(1.25 * slid) == Approx(-0.2).epsilon(1e-3));
  }
}
