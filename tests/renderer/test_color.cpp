// Tests of the fields that colour cloth.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

#include "renderer/scalar_field.h"
#include "tests/renderer/draped_scene.h"

using namespace loomstone;

TEST_CASE("values are averaged over triangles, and a constant stays itself", "[renderer]") {
  DrapedScene scene = flat_scene();
  scene.frame.stretch.setConstant(1.25);
  const Vector values = scalar_field("stretch", scene.topology, scene.frame);
  CHECK((values.array() - 1.25).abs().maxCoeff() < 1e-15);  // rounding error of a mean
  scene.frame.stretch = scene.frame.strain.col(2);
  REQUIRE(scene.frame.stretch.minCoeff() < scene.frame.stretch.maxCoeff());
  const Vector mean = scalar_field("stretch", scene.topology, scene.frame);
  CHECK(mean.minCoeff() >= scene.frame.stretch.minCoeff());
  CHECK(mean.maxCoeff() <= scene.frame.stretch.maxCoeff());
}

TEST_CASE("strain is shown as U - I, like strain limits", "[renderer]") {
  DrapedScene scene = flat_scene();
  // F = R U with U = (1.3, 0.05; 0.05, 0.9): E = (U^2 - I) / 2.
  const Eigen::RowVector3d u(1.3, 0.9, 0.05);
  const Eigen::RowVector3d green(0.5 * (u[0] * u[0] + u[2] * u[2] - 1.0),
                                 0.5 * (u[1] * u[1] + u[2] * u[2] - 1.0),
                                 0.5 * u[2] * (u[0] + u[1]));
  scene.frame.strain.rowwise() = green;
  const char* names[] = {"strain_weft", "strain_warp", "strain_shear"};
  const double shown[] = {0.3, -0.1, 0.05};
  for (int k = 0; k < 3; ++k)  // tolerance: rounding errors of two square roots
    CHECK(
        (scalar_field(names[k], scene.topology, scene.frame).array() - shown[k]).abs().maxCoeff() <
        1e-14);
  scene.frame.strain.rowwise() = Eigen::RowVector3d(-0.5, -0.5, 0.0);  // shrunk to a point
  CHECK(scalar_field("strain_weft", scene.topology, scene.frame).maxCoeff() == -1.0);
  CHECK(scalar_field("strain_shear", scene.topology, scene.frame).maxCoeff() == 0.0);
}

TEST_CASE("an automatic range covers the values, a given one is kept, a diverging one is centred",
          "[renderer]") {
  RenderOptions options;
  const Vector field = (Vector(3) << -0.01, 0.0, 0.04).finished();
  const ColorRange values = value_range("strain_warp", {field, Vector()});
  CHECK(value_range("strain_split", {field, 2.0 * field}).high == 0.08);
  CHECK(color_range(options, "strain_warp", values, false).low == -0.01);
  CHECK(color_range(options, "strain_warp", values, false).high == 0.04);
  CHECK(color_range(options, "strain_warp", values, true).low == -0.04);
  options.color_low = -1.0;
  options.color_high = 2.0;
  CHECK(color_range(options, "strain_warp", values, false).low == -1.0);
  CHECK(color_range(options, "strain_warp", values, false).high == 2.0);
  options.color_high.reset();
  CHECK(color_range(options, "strain_warp", values, false).low == -1.0);
  CHECK(color_range(options, "strain_warp", values, false).high == 0.04);
  CHECK(color_range(options, "strain_warp", values, true).high == 1.0);  // mirrored
  options.color_low = 0.1;                                               // more than all values
  CHECK(color_range(options, "strain_warp", values, false).low == 0.1);
  CHECK(color_range(options, "strain_warp", values, false).high > 0.1);
  options.color_low.reset(), options.color_high = -0.5;  // less than all values
  CHECK(color_range(options, "strain_warp", values, true).low < -0.5);
  CHECK(color_range(options, "strain_warp", values, true).high == -0.5);
  const ColorRange narrow = color_range(RenderOptions{}, "stretch", {1.0, 1.0}, false);
  CHECK(narrow.low < 1.0);
  CHECK(narrow.high > 1.0);
}

TEST_CASE("colours of a sequence mean the same in every frame", "[renderer]") {
  DrapedScene scene = flat_scene();
  scene.frame.stretch.setConstant(1.1);
  DrapedScene more = scene;
  more.frame.stretch.setConstant(1.3);
  RenderOptions options = small_options();
  options.color_by = "cloth+stretch";
  Renderer renderer(scene.topology, options);
  const std::vector<ColorRange> low = renderer.value_ranges(scene.frame),
                                high = renderer.value_ranges(more.frame);
  REQUIRE(low.size() == 2);
  CHECK(low[1].low == Approx(1.1));
  CHECK(high[1].high == Approx(1.3));
  const std::vector<ColorRange> both = {{0.0, 0.0}, {low[1].low, high[1].high}};
  CHECK(n_different(renderer.render(scene.frame), renderer.render(scene.frame, nullptr, &both)) >
        0);
  options.color_low = both[1].low, options.color_high = both[1].high;
  Renderer given(scene.topology, options);
  for (const Frame& frame : {scene.frame, more.frame})
    CHECK(n_different(renderer.render(frame, nullptr, &both), given.render(frame)) == 0);
  const std::vector<ColorRange> one = {{0.0, 1.0}};
  CHECK_THROWS_WITH(renderer.render(scene.frame, nullptr, &one),
                    Catch::Matchers::Contains("each of the 2 rows"));
}

TEST_CASE("a vertex forced to intersect looks different from one in contact", "[renderer]") {
  DrapedScene scene = flat_scene();
  RenderOptions options = small_options();
  options.color_by = "contact";
  Renderer renderer(scene.topology, options);
  std::vector<Image> pictures;
  for (const std::uint8_t mark : {0, 1, 2}) {
    std::fill(scene.frame.contact.begin(), scene.frame.contact.end(), mark);
    pictures.push_back(renderer.render(scene.frame));
  }
  CHECK(n_different(pictures[1], pictures[0]) > 0);
  CHECK(n_different(pictures[2], pictures[1]) > 0);
}
