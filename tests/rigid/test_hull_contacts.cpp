// Tests of contacts of convex polyhedra with triangles, and of bodies that fall, slide or rest on
// floors, obstacles and other bodies.
#include <catch2/catch.hpp>

#include <array>
#include <cmath>
#include <random>

#include "core/base/rotation.h"
#include "core/rigid/contacts/hull_contacts.h"
#include "tests/rigid/worlds.h"

using namespace loomstone;

namespace {

// Returns the contacts between a hull at a pose and the triangles of a mesh, in world coordinates.
std::vector<HullContact> contacts_on(const TriangleMesh& mesh, const ConvexPolyhedron& hull,
                                     const Vec3& at, const Mat3& turned, double near) {
  std::vector<std::array<Vec3, 3>> triangles;
  for (const auto& t : mesh.triangles().rowwise()) {
    triangles.emplace_back();
    for (int k = 0; k < 3; ++k)
      triangles.back()[k] = turned.transpose() * (mesh.vertices().row(t[k]).transpose() - at);
  }
  std::vector<std::vector<HullContact>> planes;
  HullOnTriangles().find({hull, triangles, triangles.size(), near, 0.02 * near, 4, {}}, planes);
  std::vector<HullContact> contacts;
  for (const auto& plane : planes)
    for (const HullContact& c : plane)
      contacts.push_back({turned * c.point + at, turned * c.normal, c.gap});
  return contacts;
}

Mat3 about(const Vec3& axis, double angle) {
  return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
}

Vec4 random_turn(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Vec4(normal(random), normal(random), normal(random), normal(random)).normalized();
}

}  // namespace

TEST_CASE("a box stands on a plane of triangles by its four corners, wherever their edges run") {
  const ConvexPolyhedron hull = box_polyhedron(Vec3(0.03, 0.02, 0.01));
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-0.2, 0.2);
  for (const Index cells : {1, 37, 80})
    for (int i = 0; i < 20; ++i) {
      const Vec3 at(place(random), place(random), 0.0099);
      const Mat3 turned = about(Vec3::UnitZ(), 20.0 * place(random));
      CAPTURE(cells, at.transpose());
      const auto contacts = contacts_on(floor_square(1.0, cells), hull, at, turned, 0.001);
      REQUIRE(contacts.size() == 4);
      std::vector<bool> met(4, false);
      for (const HullContact& contact : contacts) {
        CHECK((contact.normal - Vec3::UnitZ()).norm() < 1e-12);
        CHECK(contact.gap == Approx(-1e-4).margin(1e-15));
        const Vec3 own = turned.transpose() * (contact.point - at);
        CHECK(std::abs(own.x()) == Approx(0.03).margin(1e-12));
        CHECK(std::abs(own.y()) == Approx(0.02).margin(1e-12));
        met[(own.x() > 0) + 2 * (own.y() > 0)] = true;
      }
      CHECK(met == std::vector<bool>(4, true));
    }
}

TEST_CASE("a box that is slightly tilted has contacts at all its corners") {
  // All lower corners are close enough to meet the plane while the box turns about the deepest one.
  const ConvexPolyhedron hull = box_polyhedron(Vec3(0.05, 0.015, 0.01));
  std::mt19937 random(6);
  std::uniform_real_distribution<double> place(-0.2, 0.2);
  const double tilt = GENERATE(1e-4, 7e-4, 3e-3, 1e-2);
  const Index cells = GENERATE(1, 37, 80);
  for (int i = 0; i < 10; ++i) {
    const Vec3 at(place(random), place(random), 0.0099);
    const Vec3 axis = rotation_matrix(random_turn(random)) * Vec3::UnitX();
    const Mat3 turned = about(Vec3(axis.x(), axis.y(), 0.0).normalized(), tilt) *
                        about(Vec3::UnitZ(), 20.0 * place(random));
    CAPTURE(tilt, cells, i);
    std::vector<bool> met(4, false);
    for (const HullContact& contact :
         contacts_on(floor_square(1.0, cells), hull, at, turned, 0.002)) {
      const Vec3 own = turned.transpose() * (contact.on_hull() - at);
      if (std::abs(own.x()) > 0.049 && std::abs(own.y()) > 0.014)
        met[(own.x() > 0) + 2 * (own.y() > 0)] = true;
    }
    CHECK(met == std::vector<bool>(4, true));
  }
}

TEST_CASE(
    "a corner meets a face, a face a corner, an edge an edge, each once and in the right plane") {
  const ConvexPolyhedron cube = box_polyhedron(Vec3(0.01, 0.01, 0.01));
  const double half_diagonal = 0.01 * std::sqrt(3.0);
  const Mat3 on_tip =
      Eigen::Quaterniond::FromTwoVectors(Vec3(1, 1, 1), -Vec3::UnitZ()).toRotationMatrix();
  const auto tip = contacts_on(floor_square(1.0, 7), cube, Vec3(0.013, 0.021, half_diagonal - 1e-4),
                               on_tip, 5e-4);
  REQUIRE(tip.size() == 1);
  CHECK((tip[0].normal - Vec3::UnitZ()).norm() < 1e-12);
  CHECK(tip[0].gap == Approx(-1e-4).margin(1e-12));
  CHECK((tip[0].point - Vec3(0.013, 0.021, 0)).norm() < 1e-9);

  const TriangleMesh upright =
      box(1.0, 1.0, 1.0).moved(Vec3::Zero(), about(Vec3::UnitX(), M_PI) * on_tip);
  const auto face =
      contacts_on(upright, cube, Vec3(0.002, -0.003, upright.vertices().col(2).maxCoeff() + 0.0099),
                  about(Vec3::UnitZ(), 0.4), 5e-4);
  REQUIRE(!face.empty());
  for (const HullContact& contact : face) CHECK((contact.normal - Vec3::UnitZ()).norm() < 1e-12);
  CHECK(std::min_element(face.begin(), face.end(), [](const auto& a, const auto& b) {
          return a.gap < b.gap;
        })->gap == Approx(-1e-4).margin(1e-12));

  // Hull and mesh are cubes, each turned by 45 degrees, so that an edge of the hull crosses an edge
  // of the mesh at a right angle.
  const TriangleMesh roof = box(1.0, 1.0, 1.0).moved(Vec3::Zero(), about(Vec3::UnitX(), M_PI / 4));
  const auto cross =
      contacts_on(roof, cube, Vec3(0.1, 0.001, std::sqrt(0.5) + 0.01 * std::sqrt(2.0) - 1e-4),
                  about(Vec3::UnitY(), M_PI / 4), 5e-4);
  REQUIRE(cross.size() >= 1);
  for (const HullContact& contact : cross) {
    CHECK((contact.normal - Vec3::UnitZ()).norm() < 1e-9);
    CHECK(contact.gap == Approx(-1e-4).margin(1e-9));
    CHECK((contact.point - Vec3(0.1, 0, std::sqrt(0.5))).norm() < 1e-9);
  }
}

TEST_CASE("bodies thrown on a floor gain no energy, come to rest, and lie exactly on it") {
  const std::vector<std::pair<TriangleMesh, std::string>> things = {
      {box(0.02, 0.03, 0.015), "box"},
      {box(0.02, 0.03, 0.015), "convex"},
      {cylinder(0.004, 0.027, 14), "convex"},
      {cylinder(0.01, 0.01, 3), "convex"}};
  const double rod = 0.004 * std::cos(M_PI / 14), bar = 0.005;
  const std::vector<std::vector<double>> heights = {
      {0.01, 0.015, 0.0075}, {0.01, 0.015, 0.0075}, {rod, 0.0135}, {bar, 0.005}};
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (const bool deforms : {false, true})
    for (std::size_t k = 0; k < things.size(); ++k)
      for (int run_of = 0; run_of < 4; ++run_of) {
        CAPTURE(k, run_of, deforms);
        RigidBody body = body_of(things[k].first, things[k].second, Vec3(0.001, 0.002, 0.05));
        body.orientation = random_turn(random), body.density = 1800.0;
        for (int i = 0; i < 3; ++i)
          body.velocity[i] = 0.3 * normal(random), body.angular_velocity[i] = 20.0 * normal(random);
        const RigidObstacle flat = floor_of(4.0, deforms ? 2 : 1);
        RigidWorld world({body}, {deforms ? deforming(flat) : flat}, gravity);
        RigidState state = world.initial_state();
        const MassProperties& mass = world.mass_properties()[0];
        const auto energy = [&] {
          const Vec3 spin = rotation_matrix(state.orientations.row(0).transpose()).transpose() *
                            state.angular_velocities.row(0).transpose();
          return 0.5 * mass.mass * state.velocities.row(0).squaredNorm() +
                 0.5 * spin.dot(mass.inertia * spin) + mass.mass * 9.81 * state.positions(0, 2);
        };
        const Points none = Points::Zero(1, 3);
        const ObstaclePlaces places = deforms ? ObstaclePlaces({RigidPose{}}, flat.mesh->vertices())
                                              : ObstaclePlaces({RigidPose{}});
        double before = energy(), most = 0.0;
        const double fastest = std::sqrt(2.0 * before / mass.mass);
        for (int i = 0; i < 3000; ++i) {
          world.advance(1e-3, {none, none}, places, state);
          most = std::max(most, energy() - before), before = energy();
        }
        // The bound is the work against gravity over the largest possible displacement in a step.
        CHECK(most < mass.mass * 9.81 * fastest * 1e-3);
        const double z = state.positions(0, 2);
        CHECK(std::any_of(heights[k].begin(), heights[k].end(),
                          [&](double h) { return std::abs(z - h) < 2e-6; }));
        CHECK(state.velocities.norm() < 1e-3);
      }
}

namespace {

struct Rest {
  // Maxima in the second half of the steps: distance from the place where this half begins [m],
  // speed [m/s] and angular velocity [rad/s].
  double moved, speed, spin;
  Vec3 at;
  double most_gain;  // largest gain of energy per mass in a step [J/kg]
};

Rest come_to_rest(const RigidBody& body, const RigidObstacle& obstacle, int steps) {
  RigidWorld world({body}, {obstacle}, gravity);
  RigidState state = world.initial_state();
  const MassProperties& mass = world.mass_properties()[0];
  const Points none = Points::Zero(1, 3);
  const ObstaclePlaces places = obstacle.vertices.rows()
                                    ? ObstaclePlaces({RigidPose{}}, obstacle.vertices)
                                    : ObstaclePlaces({RigidPose{}});
  Rest rest{0.0, 0.0, 0.0, Vec3::Zero(), 0.0};
  double before = 1e300;
  for (int i = 0; i < steps; ++i) {
    world.advance(1e-3, {none, none}, places, state);
    const Vec3 at = state.positions.row(0).transpose(),
               spin = state.angular_velocities.row(0).transpose();
    const Vec3 own = rotation_matrix(state.orientations.row(0).transpose()).transpose() * spin;
    const double energy = 0.5 * state.velocities.row(0).squaredNorm() +
                          0.5 * own.dot(mass.inertia * own) / mass.mass + 9.81 * at.z();
    if (i > 0) rest.most_gain = std::max(rest.most_gain, energy - before);
    before = energy;
    if (i == steps / 2) rest.at = at;
    if (i <= steps / 2) continue;
    rest.moved = std::max(rest.moved, (at - rest.at).norm());
    rest.speed = std::max(rest.speed, state.velocities.row(0).norm());
    rest.spin = std::max(rest.spin, spin.norm());
  }
  rest.at = state.positions.row(0).transpose();
  return rest;
}

// Three faces of a room in one mesh, with their common corner at the origin.
RigidObstacle room(double size) {
  Points x(7, 3);
  x << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 0, 0, 1, 1, 1, 0, 1;
  Triangles t(6, 3);
  t << 0, 1, 4, 0, 4, 2, 0, 2, 5, 0, 5, 3, 0, 3, 6, 0, 6, 1;
  return {shared(TriangleMesh(size * x, t)), 0.3, Vec3::Zero(), Vec4(1, 0, 0, 0), Points(0, 3)};
}

}  // namespace

TEST_CASE(
    "bodies come to rest for good in corners, over posts, on fine floors, on flat ends of many "
    "corners") {
  // The body lies in the corner of the room, close to three planes.
  for (const std::string shape : {"box", "convex"}) {
    const Rest in_corner = come_to_rest(
        body_of(box(0.04, 0.03, 0.01), shape, Vec3(0.0201, 0.0151, 0.006)), room(0.3), 1000);
    CHECK(in_corner.speed < 1e-9);
    CHECK(std::abs(in_corner.at.z() - 0.005) < 1e-6);
  }
  // The body is larger than the obstacle it lies on. The side faces of the obstacle must not count
  // as supports.
  for (const Index cells : {1, 8}) {
    const RigidObstacle post{shared(box(0.04, 0.03, 0.02, cells).moved(Vec3(0, 0, -0.01))), 0.3,
                             Vec3::Zero(), Vec4(1, 0, 0, 0), Points(0, 3)};
    RigidBody plate = body_of(box(0.16, 0.12, 0.08), "box", Vec3(0.003, 0.002, 0.0425));
    plate.orientation = quaternion_from_rotation_vector(Vec3(0.04, 0.03, 0.2));
    const Rest on_post = come_to_rest(plate, post, 1500);
    CAPTURE(cells);
    CHECK(on_post.most_gain < 0.01);
    CHECK(on_post.speed < 1e-6);
    CHECK(std::abs(on_post.at.z() - 0.04) < 1e-6);
  }
  // The rod lies on a side face that covers several cells of the floor, so there are more contact
  // points than the four that can be kept. The four must include those that support the rod.
  RigidBody rod = body_of(
      cylinder(0.004, 0.027, 14)
          .moved(Vec3::Zero(), about(Vec3::UnitY(), M_PI / 2) * about(Vec3::UnitZ(), M_PI / 14)),
      "convex", Vec3(0.001, 0.002, 0.004 * std::cos(M_PI / 14)));
  const Rest on_cells = come_to_rest(rod, floor_of(0.1, 60), 1000);
  CHECK(on_cells.speed < 1e-9);
  CHECK(on_cells.spin < 1e-6);
  for (const int sides : {3, 5, 14, 15}) {
    CAPTURE(sides);
    const Rest on_end =
        come_to_rest(body_of(cylinder(0.01, 0.02, sides), "convex", Vec3(0.001, 0.002, 0.0101)),
                     floor_of(1.0, 1), 1000);
    CHECK(on_end.speed < 1e-9);
    CHECK(std::abs(on_end.at.z() - 0.01) < 1e-6);
  }
  const Rest thin = come_to_rest(
      body_of(box(0.02, 0.02, 0.0002), "box", Vec3(0.0013, 0.0021, 0.0001)), floor_of(0.6, 1), 500);
  CHECK(thin.speed < 1e-9);
  CHECK(std::abs(thin.at.z() - 1e-4) < 1e-7);
}

TEST_CASE("points inside the edges and faces of a hull change nothing") {
  std::mt19937 random(7);
  for (int k = 0; k < 20; ++k) {
    const Mat3 turned = rotation_matrix(random_turn(random));
    RigidBody body = body_of(box(0.02, 0.03, 0.015, 2).moved(Vec3::Zero(), turned), "convex",
                             Vec3(0, 0, 0.0076));
    body.orientation = quaternion_from_matrix(turned.transpose());
    const Rest rest = come_to_rest(body, floor_of(1.0, 3), 300);
    CAPTURE(k);
    CHECK(std::abs(rest.at.z() - 0.0075) < 1e-5);  // tolerance: a tenth of the initial gap
    CHECK(rest.speed < 1e-5);
  }
}

TEST_CASE(
    "points in the flat sides of a cylinder, however it lies in its mesh, leave it a polyhedron of "
    "its corners") {
  std::mt19937 random(3);
  for (int k = 0; k < 10; ++k) {
    RigidBody rod = body_of(
        cylinder(0.004, 0.027, 14).moved(Vec3::Zero(), rotation_matrix(random_turn(random))),
        "convex", Vec3(0, 0, 0.02));
    rod.orientation = random_turn(random), rod.angular_velocity = Vec3(20, 10, 5);
    const Rest rest = come_to_rest(rod, floor_of(4.0, 1), 5000);
    CAPTURE(k);
    CHECK(rest.speed < 1e-3);
    CHECK(std::min(std::abs(rest.at.z() - 0.004 * std::cos(M_PI / 14)),
                   std::abs(rest.at.z() - 0.0135)) < 2e-6);
  }
}

TEST_CASE("bodies of every size bounce as high as their restitution says") {
  for (const double size : {0.02, 0.05, 0.2}) {
    RigidBody cube = body_of(box(size, size, size), "box", Vec3(0.001, 0.002, 0.5 * size + 0.2));
    cube.restitution = 0.9;
    RigidObstacle flat = floor_of(4.0, 2);
    RigidWorld world({cube}, {flat}, gravity);
    RigidState state = world.initial_state();
    double highest = 0.0;
    for (int i = 0; i < 450; ++i) {
      run(world, state, 1e-3, 1, 1);
      if (state.velocities(0, 2) > 0.0)
        highest = std::max(highest, state.positions(0, 2) - 0.5 * size);
    }
    CAPTURE(size);
    CHECK(highest == Approx(0.81 * 0.2).epsilon(0.02));
  }
}

TEST_CASE(
    "a box slides as far over the edges of a fine surface that deforms as over one of two "
    "triangles") {
  double way[2];
  for (const int k : {0, 1}) {
    RigidBody brick = body_of(box(0.04, 0.03, 0.02), "box", Vec3(-0.2, 0.0071, 0.01));
    brick.velocity = Vec3(0.9, 0.1, 0), brick.friction = 0.3;
    const RigidObstacle flat = deforming(floor_of(0.6, k == 0 ? 1 : 20));
    RigidWorld world({brick}, {flat}, gravity);
    RigidState state = world.initial_state();
    const Vec3 start = state.positions.row(0).transpose();
    const Points none = Points::Zero(1, 3);
    for (int i = 0; i < 400; ++i)
      world.advance(1e-3, {none, none}, ObstaclePlaces({RigidPose{}}, flat.vertices), state);
    way[k] = (state.positions.row(0).transpose() - start).norm();
    CHECK(std::abs(state.positions(0, 2) - 0.01) < 1e-6);
  }
  CHECK(way[1] == Approx(way[0]).epsilon(0.005));
}

TEST_CASE("a box that falls fast stops at the surface, and one that passes by keeps its velocity") {
  for (const double step : {1e-3, 4e-3, 1e-2}) {
    CAPTURE(step);
    for (const bool deforms : {false, true}) {
      const RigidObstacle flat = deforms ? deforming(floor_of(4.0, 2)) : floor_of(4.0, 2);
      RigidBody falling = body_of(box(0.1, 0.1, 0.1), "box", Vec3(0.01, 0.02, 0.2));
      falling.velocity = Vec3(0, 0, -3);
      RigidWorld world({falling}, {flat}, gravity);
      RigidState state = world.initial_state();
      const Points none = Points::Zero(1, 3);
      double lowest = 1.0;
      for (int i = 0; i < 50; ++i) {
        world.advance(step, {none, none}, ObstaclePlaces({RigidPose{}}, flat.vertices), state);
        lowest = std::min(lowest, state.positions(0, 2) - 0.05);
      }
      // Bullet ends its iterations when the contacts are accurate to about a micrometre.
      CHECK(lowest > -5e-6);
      CHECK(lowest < 1e-4);
    }
    RigidBody gliding = body_of(box(0.1, 0.1, 0.1), "box", Vec3(-0.3, 0.02, 0.0505));
    gliding.velocity = Vec3(5, 0.3, 0), gliding.friction = 0.5;
    RigidWorld above({gliding}, {floor_of(0.4, 3, 0.5)}, Vec3::Zero());
    RigidState state = above.initial_state();
    run(above, state, step, 20, 1);
    CHECK((state.velocities.row(0).transpose() - gliding.velocity).norm() < 1e-12);
  }
}

TEST_CASE("a box that lands almost flat does not sink in at the edge that lands last") {
  const double step = GENERATE(1e-3, 4e-3, 1e-2), tilt = GENERATE(7e-4, 3e-3, 1e-2),
               speed = GENERATE(0.05, 0.3, 1.0);
  const Index cells = GENERATE(1, 40);
  CAPTURE(step, tilt, speed, cells);
  RigidBody flat = body_of(box(0.1, 0.03, 0.02), "box", Vec3(0.01, 0.02, 0.0107));
  flat.orientation = Vec4(std::cos(0.5 * tilt), 0.0, std::sin(0.5 * tilt), 0.0);
  flat.velocity = Vec3(0, 0, -speed);
  RigidWorld world({flat}, {floor_of(4.0, cells)}, gravity);
  RigidState state = world.initial_state();
  double lowest = 1.0;
  for (int i = 0; i < 50; ++i) {
    run(world, state, step, 1, 1);
    const Mat3 turned = rotation_matrix(state.orientations.row(0).transpose());
    lowest = std::min(lowest, state.positions(0, 2) - 0.05 * std::abs(turned(2, 0)) -
                                  0.015 * std::abs(turned(2, 1)) - 0.01 * turned(2, 2));
  }
  CHECK(lowest > -5e-5);  // the box turns by up to 0.01 rad within a step
  CHECK(state.velocities.row(0).norm() < 1e-3);
}

TEST_CASE("a hull of many corners that falls on a floor stops at its surface") {
  const double step = GENERATE(1e-3, 4e-3);
  const Index cells = GENERATE(1, 40);
  const double angle = GENERATE(0.0, 0.4, 1.3);
  CAPTURE(step, cells, angle);
  const TriangleMesh ball = icosphere(0.05, 1);
  RigidBody hull =
      body_of(TriangleMesh(ball.vertices() * Vec3(1.0, 0.8, 0.6).asDiagonal(), ball.triangles()),
              "convex", Vec3(0.01, 0.02, 0.06));
  hull.orientation = quaternion_from_rotation_vector(angle * Vec3(0.6, 0.8, 0.0));
  hull.velocity = Vec3(0, 0, -2);
  RigidWorld world({hull}, {floor_of(4.0, cells)}, gravity);
  RigidState state = world.initial_state();
  double lowest = 1.0;
  for (int i = 0; i < 60; ++i) {
    run(world, state, step, 1, 1);
    const Mat3 turned = rotation_matrix(state.orientations.row(0).transpose());
    const Points x = hull.mesh->vertices() * turned.transpose();
    lowest = std::min(lowest, state.positions(0, 2) + x.col(2).minCoeff());
  }
  // In steps of 4 ms, the hull sinks in by up to 1.6 mm, because it turns within a step.
  CHECK(lowest > (step < 2e-3 ? -1e-5 : -2e-3));
}

TEST_CASE("a body that falls fast on another body stops at its surface and keeps its momentum") {
  for (const char* shape : {"sphere", "box", "convex"})
    for (const double step : {1e-3, 4e-3, 1e-2}) {
      CAPTURE(shape, step);
      const bool round = std::string(shape) == "sphere";
      RigidBody below = body_of(box(0.4, 0.4, 0.2), "box");
      RigidBody falling =
          body_of(round ? icosphere(0.05, 2) : box(0.1, 0.1, 0.1), shape, Vec3(0.0, 0.0, 0.3));
      falling.velocity = Vec3(0, 0, -3);
      RigidWorld world({below, falling}, {}, Vec3::Zero());
      RigidState state = world.initial_state();
      const double m = world.mass_properties()[0].mass, n = world.mass_properties()[1].mass;
      double least = 1.0;
      for (int i = 0; i < 60; ++i) {
        run(world, state, step, 1, 0);
        least = std::min(least, state.positions(1, 2) - state.positions(0, 2) - 0.15);
      }
      // Bullet's margin around a hull is up to 0.04 mm. The depth that Bullet finds for a sphere in
      // a box is approximate: without contacts ahead of the motion, the sphere would sink by 6 mm
      // in steps of 4 ms.
      CHECK(least > (round ? -2e-3 : -4e-5));
      CHECK(least < 2e-4);
      CHECK(m * state.velocities(0, 2) + n * state.velocities(1, 2) == Approx(-3.0 * n));
    }
}

// Both ends of a vertical edge are nearer to the floor than the contact distance, which is about
// 1 % of the diagonal of the bounding box. They also have the same nearest point of the floor.
TEST_CASE("thin plates and rods rest on a floor by whichever side they lie on") {
  const std::string shape = GENERATE("box", "convex");
  const bool upside_down = GENERATE(false, true);
  const Vec3 size =
      GENERATE(Vec3(0.3, 0.3, 0.002), Vec3(0.5, 0.004, 0.004), Vec3(0.3, 0.03, 0.001));
  CAPTURE(shape, upside_down, size.transpose());
  RigidBody body =
      body_of(box(size.x(), size.y(), size.z()), shape, Vec3(0.25, 0.25, 0.5 * size.z()));
  if (upside_down) body.orientation = Vec4(0, 1, 0, 0);
  RigidWorld world({body}, {floor_of(2.0, 1)}, gravity);
  RigidState state = world.initial_state();
  run(world, state, 1e-3, 200, 1);
  CHECK(state.positions(0, 2) == Approx(0.5 * size.z()).epsilon(0.02));
}
