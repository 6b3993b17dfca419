// Tests of input that the renderer refuses. Each error message names the faulty input.
#include <catch2/catch.hpp>

#include <limits>

#include "core/base/error.h"
#include "tests/renderer/draped_scene.h"

using namespace loomstone;
using Catch::Matchers::Contains;

namespace {

template <class Change>
void refuses_options(Change change, const std::string& words) {
  const DrapedScene scene = draped_scene(4, 0);
  RenderOptions options = small_options();
  change(options);
  INFO("expected: " << words);
  CHECK_THROWS_AS(Renderer(scene.topology, options), InvalidInput);
  CHECK_THROWS_WITH(Renderer(scene.topology, options), Contains(words));
}

template <class Change>
void refuses_frame(Change change, const std::string& color_by, const std::string& words) {
  DrapedScene scene = draped_scene(4, 0);
  RenderOptions options = small_options();
  options.color_by = color_by;
  Renderer renderer(scene.topology, options);
  change(scene.frame);
  INFO("expected: " << words);
  CHECK_THROWS_AS(renderer.render(scene.frame), InvalidInput);
  CHECK_THROWS_WITH(renderer.render(scene.frame), Contains(words));
}

template <class Change>
void refuses_topology(Change change, const std::string& words) {
  DrapedScene scene = draped_scene(4, 0);
  change(scene.topology);
  INFO("expected: " << words);
  CHECK_THROWS_AS(Renderer(scene.topology, small_options()), InvalidInput);
  CHECK_THROWS_WITH(Renderer(scene.topology, small_options()), Contains(words));
}

const double not_a_number = std::numeric_limits<double>::quiet_NaN();

}  // namespace

TEST_CASE("options that cannot be drawn are refused with the choices", "[renderer]") {
  refuses_options([](RenderOptions& o) { o.width = 8; }, "width");
  refuses_options([](RenderOptions& o) { o.height = 100000; }, "height");
  refuses_options([](RenderOptions& o) { o.width = 16384, o.samples = 3; },
                  "samples must be 1, 2, 4 or 8");
  refuses_options([](RenderOptions& o) { o.samples = 8; }, "at most");  // llvmpipe offers up to 4
  CHECK_THROWS_WITH(choice_named<ClothPattern>("tartan", "render.pattern"),
                    Contains("weave | checker | plain, got \"tartan\""));
  refuses_options([](RenderOptions& o) { o.color_by = "speed"; },
                  "cloth, stretch, strain_weft, strain_warp");
  refuses_options([](RenderOptions& o) { o.color_by = "stretch+"; }, "contact, got ''");
  refuses_options([](RenderOptions& o) { o.color_low = o.color_high = 2.0; },
                  "color_low must be less than color_high, got 2 and 2");
  refuses_options([](RenderOptions& o) { o.color_high = not_a_number; }, "color_high");
  refuses_options([](RenderOptions& o) { o.hidden = "ball+wall"; },
                  "hidden must be ball or floor, got 'wall'");
  refuses_options([](RenderOptions& o) { o.light_direction.setZero(); }, "light_direction");
  refuses_options([](RenderOptions& o) { o.camera.field_of_view_degrees = 180.0; },
                  "field_of_view_degrees");
  refuses_options([](RenderOptions& o) { o.camera.eye.x() = not_a_number; },
                  "camera.eye must be finite");
  refuses_options([](RenderOptions& o) { o.camera.fit = false; }, "eye and target must differ");
  refuses_options([](RenderOptions& o) { o.camera.eye = Vec3(0, 0, 2); }, "camera.up");
  refuses_options([](RenderOptions& o) { o.camera.eyes = Points::Ones(2, 3); }, "need times");
  refuses_options([](RenderOptions& o) { o.camera.times = {0.0, 1.0}; },
                  "each of its 2 times, got 0 and 0");
  refuses_options(
      [](RenderOptions& o) {
        o.camera.times = {1.0, 1.0};
        o.camera.eyes = Points::Ones(2, 3);
      },
      "ascending [s], got 1 at entry 1");
  refuses_options(
      [](RenderOptions& o) {
        o.camera.times = {1.0};
        o.camera.eyes = Points::Zero(1, 3);
      },
      "keyframe 0 must have a target other than its eye");
}

TEST_CASE("frames that are not finite or not of this run are refused", "[renderer]") {
  refuses_frame([](Frame& f) { f.positions(3, 1) = not_a_number; }, "cloth",
                "positions of a frame must be finite, but row 3");
  refuses_frame([](Frame& f) { f.body_vertices(2, 0) = not_a_number; }, "cloth",
                "body_vertices of a frame must be finite");
  refuses_frame([](Frame& f) { f.positions.conservativeResize(5, 3); }, "cloth",
                "25 rows of positions, got 5");
  refuses_frame([](Frame& f) { f.body_vertices.resize(0, 3); }, "cloth", "rows of body_vertices");
  refuses_frame([](Frame& f) { f.stretch.resize(0); }, "stretch", "rows of stretch");
  refuses_frame([](Frame& f) { f.stretch[0] = not_a_number; }, "stretch",
                "stretch of a frame must be finite");
  refuses_frame([](Frame& f) { f.strain.resize(0, 3); }, "strain_weft", "rows of strain");
  refuses_frame([](Frame& f) { f.strain(1, 2) = not_a_number; }, "strain_shear",
                "strain of a frame must be finite");
  refuses_frame([](Frame& f) { f.contact.clear(); }, "contact", "rows of contact");
}

TEST_CASE("a topology that contradicts itself is refused", "[renderer]") {
  refuses_topology([](FrameTopology& t) { t.corner_uv.resize(3, 2); }, "three rows of corner_uv");
  refuses_topology([](FrameTopology& t) { t.corner_uv(0, 0) = not_a_number; },
                   "corner_uv of the topology must be finite");
  refuses_topology([](FrameTopology& t) { t.body_is_floor.clear(); }, "whether it is a floor");
  refuses_topology([](FrameTopology& t) { t.triangles(2, 1) = 25; },
                   "triangles must hold vertex indices in [0, 25), but row 2");
  refuses_topology([](FrameTopology& t) { t.body_triangles(1, 1) = -1; },
                   "body_triangles must hold vertex indices");
  refuses_topology([](FrameTopology& t) { t.cloth_looks.resize(3); }, "each of its 1 cloths");
  refuses_topology([](FrameTopology& t) { t.body_looks.resize(3); }, "each of its 2 bodies");
  refuses_topology([](FrameTopology& t) { t.body_corner_uv.resize(3, 2); },
                   "three rows of body_corner_uv");
  refuses_topology([](FrameTopology& t) { t.cloth_looks = {Look{Vec3(0, 255, 0), {}, {}, 0.0}}; },
                   "color must be in [0, 1], got (0, 255, 0)");
  refuses_topology([](FrameTopology& t) { t.cloth_of_triangle[0] = 1; },
                   "cloth_of_triangle must lie in [0, 1)");
}
