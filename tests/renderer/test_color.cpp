// Claims about colour maps, fields, the colour bar and its text.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

#include "renderer/color_bar.h"
#include "renderer/stroke_font.h"
#include "tests/renderer/draped_scene.h"

using namespace loomstone;

namespace {

// Lightness L* of CIELAB.
double lightness(const Color& color) {
  double y = 0.0;
  const double weight[] = {0.2126, 0.7152, 0.0722};
  for (int channel = 0; channel < 3; ++channel) {
    const double c = color[channel] / 255.0;
    y += weight[channel] * (c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
  }
  return y > 0.008856 ? 116.0 * std::cbrt(y) - 16.0 : 903.3 * y;
}

bool near(const Color& a, const Color& b, int tolerance) {
  return std::equal(a.begin(), a.end(), b.begin(),
                    [&](int x, int y) { return std::abs(x - y) <= tolerance; });
}

Color at(const Image& image, int x, int y) {
  const std::size_t i = 3 * (static_cast<std::size_t>(y) * image.width + x);
  return {image.rgb[i], image.rgb[i + 1], image.rgb[i + 2]};
}

}  // namespace

TEST_CASE("lightness of viridis and magma grows evenly", "[renderer]") {
  for (const ColorMap map : {ColorMap::Viridis, ColorMap::Magma}) {
    const ColorTable table = color_table(map);
    const double slope = (lightness(table[255]) - lightness(table[0])) / 255.0;
    for (int i = 0; i < 256; ++i)  // measured deviation from a line: up to 4.3
      CHECK(std::abs(lightness(table[i]) - lightness(table[0]) - slope * i) < 5.0);
  }
}

TEST_CASE("viridis and magma have their published colours at ends and middle", "[renderer]") {
  // The polynomials differ from the tables of Smith and van der Walt by at most 5 of 255.
  const ColorTable viridis = color_table(ColorMap::Viridis), magma = color_table(ColorMap::Magma);
  CHECK(near(viridis[0], {68, 1, 84}, 5));
  CHECK(near(viridis[128], {33, 145, 140}, 5));
  CHECK(near(viridis[255], {253, 231, 37}, 5));
  CHECK(near(magma[0], {0, 0, 4}, 5));
  CHECK(near(magma[128], {183, 55, 121}, 5));
  CHECK(near(magma[255], {252, 253, 191}, 5));
}

TEST_CASE("the diverging map is lightest and grey in the middle and as light at both ends",
          "[renderer]") {
  const ColorTable table = color_table(ColorMap::Diverging);
  CHECK(near(table[0], {59, 76, 192}, 1));  // Moreland's end colours
  CHECK(near(table[255], {180, 4, 38}, 1));
  CHECK(near(table[127], {221, 221, 221}, 2));
  for (int i = 1; i < 128; ++i) {
    CHECK(lightness(table[i]) >= lightness(table[i - 1]) - 0.5);  // rounding to 8 bits
    CHECK(lightness(table[255 - i]) >= lightness(table[256 - i]) - 0.5);
  }
}

TEST_CASE("the ends of the colour bar have the end colours and the numbers of the range",
          "[renderer]") {
  DrapedScene scene = draped_scene(12, 1);
  for (const char* field : {"stretch", "strain_weft", "strain_warp", "strain_shear", "contact"}) {
    RenderOptions options;
    options.width = 640;
    options.height = 360;
    options.color_by = field;
    options.color_map = ColorMap::Magma;
    const Image image = Renderer(scene.topology, options).render(scene.frame);
    const ColorTable table = color_table(ColorMap::Magma);
    const ColorBarPlace place = color_bar_place(image.width, image.height);
    const int middle = place.left + place.width / 2;
    CHECK(at(image, middle, place.top) == table[255]);
    CHECK(at(image, middle, place.top + place.height - 1) == table[0]);
  }
  const std::vector<ColorBarLabel> labels = color_bar_labels({1.0, 1.25});
  CHECK(labels.front().text == "1.00");
  CHECK(labels.back().text == "1.25");
  CHECK(color_bar_labels({-0.0413, 0.0413}).front().text == "-0.0413");
  CHECK(color_bar_labels({0.0, 3e7}).back().text == "3e+07");
}

TEST_CASE("labels of the colour bar stand where their numbers are and never collide",
          "[renderer]") {
  for (const ColorRange& range :
       {ColorRange{0, 1}, {1.0, 1.55}, {-0.2, 0.17}, {1.0, 1.000002}, {-3000, 12000}}) {
    const std::vector<ColorBarLabel> labels = color_bar_labels(range);
    REQUIRE(labels.size() >= 3);
    for (std::size_t i = 1; i < labels.size(); ++i)
      CHECK(labels[i].share - labels[i - 1].share > 0.08);
    if (range.high - range.low > 1e-3)
      for (const ColorBarLabel& label : labels)  // rounded by up to 0.005 of the range
        CHECK(std::abs(std::stod(label.text) - range.low -
                       label.share * (range.high - range.low)) <= 0.006 * (range.high - range.low));
  }
}

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
  CHECK(color_range(options, "strain_warp", values).low == -0.01);
  CHECK(color_range(options, "strain_warp", values).high == 0.04);
  options.color_map = ColorMap::Diverging;
  CHECK(color_range(options, "strain_warp", values).low == -0.04);
  options.color_low = -1.0;
  options.color_high = 2.0;
  CHECK(color_range(options, "strain_warp", values).low == -1.0);
  CHECK(color_range(options, "strain_warp", values).high == 2.0);
  const ColorRange narrow = color_range(RenderOptions{}, "stretch", {1.0, 1.0});
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

TEST_CASE("text is visible, stays within its width, and is cut at the edge of the picture",
          "[renderer]") {
  const Color ink = {0, 0, 0};
  Image image{200, 40, std::vector<std::uint8_t>(3 * 200 * 40, 255)};
  draw_text(image, "strain 0123456789-+.[]", -30.0, 30.0, 14.0, ink);
  CHECK(std::count(image.rgb.begin(), image.rgb.end(), 0) > 300);
  for (const char sign : std::string("0123456789.-+[]abcdefghijklmnopqrstuvwxyz")) {
    Image one{60, 60, std::vector<std::uint8_t>(3 * 60 * 60, 255)};
    const std::string text(1, sign);
    draw_text(one, text, 20.0, 40.0, 20.0, ink);
    int dark = 0, outside = 0;
    for (int y = 0; y < 60; ++y) {
      for (int x = 0; x < 60; ++x) {
        if (at(one, x, y)[0] > 127) continue;
        ++dark;
        const double right = 20.0 + text_width(text, 20.0);
        outside +=
            x < 17 || x > right + 3.0 || y < 16 || y > 49;  // margin: half a stroke, tail of j
      }
    }
    INFO("glyph " << sign);
    CHECK(dark > 2);
    CHECK(outside == 0);
  }
}
