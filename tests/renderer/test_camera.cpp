// Tests of camera framing, camera motion, shading normals, and the view of the light for shadows.
#include <catch2/catch.hpp>

#include <cmath>

#include "renderer/camera.h"
#include "renderer/mesh_buffers.h"
#include "renderer/shadow_pass.h"
#include "tests/renderer/draped_scene.h"

using namespace loomstone;

TEST_CASE("a fitted camera sees the whole box in the middle, touching the margin on two sides",
          "[renderer]") {
  for (const Vec3& direction :
       {Vec3(1, -1, 0.5), Vec3(0, -1, 0), Vec3(-0.3, 0.2, 1), Vec3(0, 0, 0)}) {
    for (double aspect : {0.5, 1.0, 16.0 / 9.0}) {
      const Framing framing{Vec3(-0.2, -0.6, 0.1), Vec3(0.4, 0.3, 0.5)};
      Camera camera;
      camera.eye = direction;
      const View view = make_view(camera, aspect, framing);
      Eigen::Vector2f low = Eigen::Vector2f::Constant(1e9f), high = -low;
      for (int corner = 0; corner < 8; ++corner) {
        const Eigen::Vector4f p(static_cast<float>(corner & 1 ? 0.4 : -0.2),
                                static_cast<float>(corner & 2 ? 0.3 : -0.6),
                                static_cast<float>(corner & 4 ? 0.5 : 0.1), 1.0f);
        const Eigen::Vector4f clip = view.projection() * view.view() * p;
        CHECK(clip.w() > 0.0f);
        CHECK(std::abs(clip.z()) < clip.w());
        low = low.cwiseMin(clip.head<2>() / clip.w());
        high = high.cwiseMax(clip.head<2>() / clip.w());
      }
      // The tolerance covers the rounding errors of single precision.
      CHECK(std::max({high.x(), high.y(), -low.x(), -low.y()}) == Approx(0.92).margin(1e-4));
      CHECK(high.x() == Approx(-low.x()).margin(1e-4));
      CHECK(high.y() == Approx(-low.y()).margin(1e-4));
    }
  }
}

TEST_CASE("a fitted camera shows cloth and bodies up to the margin, and keeps that as it turns",
          "[renderer]") {
  const DrapedScene scene = draped_scene(12, 2);
  for (const double turn : {0.0, 36.0}) {
    RenderOptions options = small_options();
    options.camera.eye = Vec3(1.0, -1.0, 0.6);
    options.camera.turn = turn;
    CameraFit fit(scene.topology, options);
    fit.include(scene.frame);
    DrapedScene later = scene;
    later.frame.positions.col(0).array() += 0.2;
    fit.include(later.frame);
    const Camera camera = fit.camera();
    CHECK_FALSE(camera.fit);
    double widest = 0.0;
    for (double time = 0.0; time < 10.0; time += 0.1) {
      const View view =
          make_view(camera, 320.0 / 180.0, make_framing(scene.topology, scene.frame), time);
      double most = 0.0;
      for (const Frame& frame : {scene.frame, later.frame})
        for (Index vertex = 0; vertex < frame.positions.rows(); ++vertex) {
          const Vec3 p = frame.positions.row(vertex).transpose() - view.eye;
          const double depth = p.dot(view.forward);
          most = std::max({most, std::abs(p.dot(view.right)) / (depth * view.tangent_x),
                           std::abs(p.dot(view.up)) / (depth * view.tangent_y)});
        }
      CHECK(most < 0.92 + 1e-6);
      if (turn == 0.0) CHECK(most > 0.92 - 1e-6);
      widest = std::max(widest, most);
    }
    CHECK(widest > 0.9);
  }
}

TEST_CASE("a camera goes through its keyframes, smoothly, and stays at the ends", "[renderer]") {
  Camera camera;
  camera.times = {0.0, 1.0, 3.0};
  camera.eyes.resize(3, 3);
  camera.eyes << 2, 0, 0, 0, 2, 1, -2, 0, 0;
  camera.targets = Points::Zero(3, 3);
  camera.targets(2, 2) = 0.5;
  const Framing framing{Vec3::Constant(-1.0), Vec3::Constant(1.0)};
  const auto at = [&](double time) { return make_view(camera, 1.0, framing, time); };
  for (Index key = 0; key < 3; ++key) {
    const View view = at(camera.times[static_cast<std::size_t>(key)]);
    CHECK((view.eye - camera.eyes.row(key).transpose()).norm() < 1e-14);
    const Vec3 sight = (camera.targets.row(key) - camera.eyes.row(key)).normalized();
    CHECK((view.forward - sight).norm() < 1e-14);
  }
  CHECK((at(-1.0).eye - at(0.0).eye).norm() == 0.0);
  CHECK((at(9.0).eye - at(3.0).eye).norm() == 0.0);
  const double h = 1e-4;  // step of the difference quotients on both sides of a keyframe [s]
  const Vec3 before = (at(1.0).eye - at(1.0 - h).eye) / h,
             after = (at(1.0 + h).eye - at(1.0).eye) / h;
  CHECK(before.norm() > 0.5);
  CHECK((before - after).norm() < 20.0 * h);  // second derivatives are below 10
}

TEST_CASE("framing leaves room for the fall, down to the floor but no further", "[renderer]") {
  DrapedScene flat = flat_scene();
  for (Index v = 0; v < flat.frame.positions.rows(); ++v) {  // lays the cloth at a height of 1 m
    flat.frame.positions.row(v) << flat.frame.positions(v, 0), flat.frame.positions(v, 2), 1.0;
  }
  CHECK(make_framing(flat.topology, flat.frame).low.z() == Approx(0.5));
  flat.topology.body_names = {"floor"};
  flat.topology.body_is_floor = {1};
  flat.topology.body_of_vertex = {0};
  flat.frame.body_vertices.resize(1, 3);
  flat.frame.body_vertices.row(0) << 40.0, 0.0, 0.8;
  const Framing framing = make_framing(flat.topology, flat.frame);
  CHECK(framing.low.z() == Approx(0.8));
  CHECK(framing.high.x() == Approx(0.25));  // a floor does not widen the picture
}

TEST_CASE("the picture of a fitted camera stays while the cloth moves", "[renderer]") {
  DrapedScene scene = draped_scene(10, 2);
  RenderOptions options = small_options();
  options.shadows = options.ambient_occlusion = false;
  Renderer renderer(scene.topology, options);
  const Image before = renderer.render(scene.frame);
  DrapedScene lower = scene;
  lower.frame.positions.col(2).array() -= 1.0;  // moves the cloth out of sight
  renderer.render(lower.frame);
  CHECK(n_different(before, renderer.render(scene.frame)) == 0);
}

TEST_CASE("a picture depends on the first frame of its run, not on what was drawn before it",
          "[renderer]") {
  const DrapedScene scene = draped_scene(10, 2);
  DrapedScene later = scene;
  later.frame.positions.col(2).array() -= 0.1;
  // The first frame decides which edges are sharp. A ball that is round in the first frame stays
  // smooth, and one that is flattened there has sharp edges.
  later.frame.body_vertices.col(2) *= 0.05;
  const RenderOptions options = small_options();
  Renderer in_order(scene.topology, options), at_once(scene.topology, options),
      alone(scene.topology, options);
  in_order.render(scene.frame);
  const Image picture = in_order.render(later.frame);
  at_once.fit(scene.frame);
  CHECK(n_different(picture, at_once.render(later.frame)) == 0);
  CHECK(n_different(picture, alone.render(later.frame)) > 0);
  in_order.fit(later.frame);
  CHECK(n_different(alone.render(later.frame), in_order.render(later.frame)) == 0);
}

TEST_CASE("normals are smooth on a ball, split on a box, and true on both", "[renderer]") {
  const DrapedScene scene = draped_scene(4, 3);
  const DrawnMesh ball = drawn_bodies(scene.topology, scene.frame.body_vertices);
  CHECK(ball.vertex.size() == 642);  // no vertex is split, and the floor is left out
  const Points normals = shading_normals(ball, scene.frame.body_vertices);
  // The tolerance of 2.6 degrees is about a third of the angle that an edge of the ball spans.
  for (Index k = 0; k < normals.rows(); ++k) {
    const Vec3 outwards = Vec3(scene.frame.body_vertices.row(ball.vertex[k])).normalized();
    CHECK(normals.row(k).dot(outwards) > 0.999);
  }

  FrameTopology cube;
  cube.body_names = {"cube"};
  cube.body_is_floor = {0};
  Points corners(8, 3);
  for (int c = 0; c < 8; ++c) corners.row(c) << (c & 1), (c >> 1 & 1), (c >> 2);
  cube.body_triangles.resize(12, 3);
  cube.body_triangles << 0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0,
      4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5;
  cube.body_of_triangle.assign(12, 0);
  cube.body_of_vertex.assign(8, 0);
  const DrawnMesh drawn = drawn_bodies(cube, corners);
  CHECK(drawn.vertex.size() == 24);
  const Points flat = shading_normals(drawn, corners);
  for (Index t = 0; t < 12; ++t) {
    const Vec3 a = corners.row(cube.body_triangles(t, 0)),
               b = corners.row(cube.body_triangles(t, 1)),
               c = corners.row(cube.body_triangles(t, 2));
    for (int corner = 0; corner < 3; ++corner)
      CHECK(flat.row(drawn.triangles(t, corner)).dot((b - a).cross(c - a).normalized()) ==
            Approx(1.0));
  }
}

TEST_CASE("cloth is split where its uv differ at a vertex, but shaded smoothly across",
          "[renderer]") {
  DrapedScene scene = flat_scene(2);
  const std::size_t before = drawn_cloth(scene.topology).vertex.size();
  CHECK(before == 9);
  // Makes the upper row of cells a separate panel.
  scene.topology.corner_uv.bottomRows(12).array() += 1.0;
  const DrawnMesh split = drawn_cloth(scene.topology);
  CHECK(split.vertex.size() == 12);
  scene.frame.positions(4, 1) = 0.1;  // makes the cloth non-flat
  const Points normals = shading_normals(split, scene.frame.positions);
  for (std::size_t i = 0; i < split.vertex.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (split.vertex[i] == split.vertex[j])
        CHECK((normals.row(static_cast<Index>(i)) - normals.row(static_cast<Index>(j))).norm() ==
              0.0);
}

TEST_CASE("the light covers the box and moves in whole texels", "[renderer]") {
  const Vec3 low(-0.3, -0.2, 0.0), high(0.3, 0.4, 0.5), shift(0.0123, 0.0045, -0.0031),
      direction(-0.5, -0.6, 1.0);
  const LightView here = make_light_view(direction, low, high),
                  there = make_light_view(direction, low + shift, high + shift);
  CHECK(here.radius == there.radius);
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector4f p(corner & 1 ? 0.3f : -0.3f, corner & 2 ? 0.4f : -0.2f,
                            corner & 4 ? 0.5f : 0.0f, 1.0f);
    CHECK((here.matrix * p).head<3>().cwiseAbs().maxCoeff() < 1.0f);
    const Eigen::Vector2f texels = ((there.matrix - here.matrix) * p).head<2>() * 0.5f *
                                   static_cast<float>(ShadowPass::resolution);
    for (int axis = 0; axis < 2; ++axis)
      CHECK(std::abs(texels[axis] - std::round(texels[axis])) < 0.01f);
  }
}
