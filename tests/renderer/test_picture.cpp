// Tests of what pictures show: cloth, bodies, floor, shadows, ambient occlusion and patterns.
#include <catch2/catch.hpp>

#include <array>
#include <cmath>

#include "tests/renderer/draped_scene.h"

using namespace loomstone;

namespace {

std::array<int, 3> pixel(const Image& image, int x, int y) {
  const std::size_t at = 3 * (static_cast<std::size_t>(y) * image.width + x);
  return {image.pixels[at], image.pixels[at + 1], image.pixels[at + 2]};
}

int brightness(const Image& image, int x, int y) {
  const auto [r, g, b] = pixel(image, x, y);
  return r + g + b;
}

// Returns whether a pixel shows the cloth, which is the only blue surface.
bool is_cloth(const Image& image, int x, int y) {
  const auto [r, g, b] = pixel(image, x, y);
  return b > r + 20;
}

Camera fixed_camera(const Vec3& eye, double field_of_view_degrees) {
  Camera camera;
  camera.eye = eye;
  camera.field_of_view_degrees = field_of_view_degrees;
  camera.fit = false;
  return camera;
}

}  // namespace

TEST_CASE("the same frame gives the same picture twice, from one renderer and from two",
          "[renderer]") {
  const DrapedScene scene = draped_scene();
  Renderer first(scene.topology, small_options()), second(scene.topology, small_options());
  const Image image = first.render(scene.frame);
  CHECK(n_different(image, first.render(scene.frame)) == 0);
  CHECK(n_different(image, second.render(scene.frame)) == 0);
}

TEST_CASE("a square of cloth covers the pixels that perspective gives it", "[renderer]") {
  // The square of cloth is 0.5 m wide and 1 m away. The tangent of half the vertical field of view
  // is 0.5, so the picture shows a height of 1 m, of which the square covers half.
  const DrapedScene scene = flat_scene();
  RenderOptions options = small_options();
  options.pattern = ClothPattern::Plain;
  options.camera =
      fixed_camera(Vec3(0, -1, 0), 2.0 * std::atan(0.5) * 180.0 / 3.14159265358979323846);
  const Image image = Renderer(scene.topology, options).render(scene.frame);
  int covered = 0, wrong = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      covered += is_cloth(image, x, y);
      const double away = std::max(std::abs(x + 0.5 - 160.0), std::abs(y + 0.5 - 90.0));
      if (std::abs(away - 45.0) > 1.0)
        wrong += is_cloth(image, x, y) != (away < 45.0);  // edge pixels are blended
    }
  }
  CHECK(wrong == 0);
  CHECK(std::abs(covered - 90 * 90) <= 4 * 90);  // tolerance: one pixel along the edge
}

TEST_CASE("cloth that reaches behind the eye is drawn up to the edge of the picture",
          "[renderer]") {
  // The cloth lies flat 0.1 m below the eye, with half of it behind the eye. The lowest rays meet
  // it 0.2 m ahead, where the view is 0.36 m wide and thus narrower than the cloth.
  DrapedScene scene = flat_scene();
  scene.frame.positions.col(1) = scene.frame.positions.col(2);
  scene.frame.positions.col(2).setConstant(-0.1);
  RenderOptions options = small_options();
  options.pattern = ClothPattern::Plain;
  options.camera =
      fixed_camera(Vec3(0, 0, 0), 2.0 * std::atan(0.5) * 180.0 / 3.14159265358979323846);
  options.camera.target = Vec3(0, 1, 0);
  const Image image = Renderer(scene.topology, options).render(scene.frame);
  for (int x = 0; x < image.width; ++x) CHECK(is_cloth(image, x, image.height - 1));
  CHECK_FALSE(is_cloth(image, 160, 90));
}

TEST_CASE("cloth is seen from both sides, and the sides differ in colour", "[renderer]") {
  const DrapedScene scene = flat_scene();
  RenderOptions options = small_options();
  options.pattern = ClothPattern::Plain;
  options.light_direction = Vec3(0, -1e-3, 1);  // light that grazes the cloth
  options.camera = fixed_camera(Vec3(0, -1, 0), 50.0);
  const Image front = Renderer(scene.topology, options).render(scene.frame);
  options.camera = fixed_camera(Vec3(0, 1, 0), 50.0);
  const Image back = Renderer(scene.topology, options).render(scene.frame);
  CHECK(is_cloth(front, 160, 90));
  CHECK(is_cloth(back, 160, 90));
  CHECK(pixel(front, 160, 90) != pixel(back, 160, 90));
}

TEST_CASE("the floor is darker in the shadow of the cloth, and only with shadows on",
          "[renderer]") {
  const DrapedScene scene = draped_scene();
  RenderOptions options = small_options();
  options.ambient_occlusion = false;
  const Image with = Renderer(scene.topology, options).render(scene.frame);
  options.shadows = false;
  const Image without = Renderer(scene.topology, options).render(scene.frame);
  int darker = 0, brighter = 0, floor_pixels = 0;
  for (int y = 0; y < with.height; ++y) {
    for (int x = 0; x < with.width; ++x) {
      if (is_cloth(without, x, y) || is_cloth(with, x, y)) continue;
      ++floor_pixels;
      darker += brightness(with, x, y) < brightness(without, x, y) - 60;
      brighter += brightness(with, x, y) > brightness(without, x, y);
    }
  }
  CHECK(darker > floor_pixels / 50);
  CHECK(darker < floor_pixels / 3);
  CHECK(brighter == 0);
  CHECK(pixel(with, 2, 2) == pixel(without, 2, 2));
}

TEST_CASE("the shadow map casts no shadow beyond its reach", "[renderer]") {
  // Beyond the reach of the shadow map, the floor must be lit. If lookups outside the map wrapped
  // around or returned the values at its border, the floor would show shadows there.
  const DrapedScene scene = draped_scene();
  RenderOptions options = small_options();
  options.ambient_occlusion = false;
  options.light_direction = Vec3(0, -0.3, 1);
  options.camera = fixed_camera(Vec3(0, -4, 1.5), 40.0);
  const Image with = Renderer(scene.topology, options).render(scene.frame);
  options.shadows = false;
  const Image without = Renderer(scene.topology, options).render(scene.frame);
  int changed_far = 0;
  for (int y = 0; y < with.height; ++y)
    for (int x = 0; x < with.width; ++x)
      if (std::abs(x - 160) > 70) changed_far += pixel(with, x, y) != pixel(without, x, y);
  CHECK(changed_far == 0);
}

TEST_CASE("ambient occlusion only darkens", "[renderer]") {
  const DrapedScene scene = draped_scene();
  RenderOptions options = small_options();
  options.pattern = ClothPattern::Plain;
  const Image with = Renderer(scene.topology, options).render(scene.frame);
  options.ambient_occlusion = false;
  const Image without = Renderer(scene.topology, options).render(scene.frame);
  int darker = 0, brighter = 0;
  for (int y = 0; y < with.height; ++y) {
    for (int x = 0; x < with.width; ++x) {
      darker += brightness(with, x, y) < brightness(without, x, y) - 3;
      // The tolerance covers rounding of three channels.
      brighter += brightness(with, x, y) > brightness(without, x, y) + 3;
    }
  }
  CHECK(darker > 200);  // pixels in the hollow under the cloth and in its folds
  CHECK(brighter == 0);
}

TEST_CASE("every pattern, the wireframe, the floor and the number of samples change the picture",
          "[renderer]") {
  const DrapedScene scene = draped_scene();
  const RenderOptions usual = small_options();
  const Image reference = Renderer(scene.topology, usual).render(scene.frame);
  const auto changed = [&](auto change) {
    RenderOptions options = usual;
    change(options);
    return n_different(reference, Renderer(scene.topology, options).render(scene.frame));
  };
  CHECK(changed([](RenderOptions&) {}) == 0);
  CHECK(changed([](RenderOptions& o) { o.pattern = ClothPattern::Checker; }) > 1000);
  CHECK(changed([](RenderOptions& o) { o.pattern = ClothPattern::Plain; }) > 1000);
  CHECK(changed([](RenderOptions& o) { o.wireframe = true; }) > 1000);
  CHECK(changed([](RenderOptions& o) { o.floor = false; }) > 1000);
  CHECK(changed([](RenderOptions& o) { o.light_direction = Vec3(1, 0, 1); }) > 1000);
  CHECK(changed([](RenderOptions& o) { o.samples = 1; }) > 100);  // pixels at edges
}

TEST_CASE("a floor does not block the view: from below it is not drawn", "[renderer]") {
  const DrapedScene scene = draped_scene();
  RenderOptions options = small_options();
  options.camera = fixed_camera(Vec3(0.3, -1.5, -1.2), 35.0);
  const Image image = Renderer(scene.topology, options).render(scene.frame);
  options.floor = false;
  CHECK(n_different(image, Renderer(scene.topology, options).render(scene.frame)) == 0);
}

TEST_CASE("what is hidden is not drawn and casts no shadow", "[renderer]") {
  DrapedScene scene = draped_scene();
  RenderOptions options = small_options();
  options.hidden = "ball+floor";
  const Image hidden = Renderer(scene.topology, options).render(scene.frame);
  options.hidden.clear();
  CHECK(hidden.pixels != Renderer(scene.topology, options).render(scene.frame).pixels);
  scene.topology.body_triangles.resize(0, 3);
  scene.topology.body_of_triangle.clear();
  scene.topology.body_is_floor.assign(scene.topology.body_is_floor.size(), 0);
  scene.frame.body_vertices *= 100.0;  // vertices without triangles do not affect shadows
  CHECK(hidden.pixels == Renderer(scene.topology, options).render(scene.frame).pixels);
}

TEST_CASE("scenes without cloth or without bodies are drawn too", "[renderer]") {
  DrapedScene scene = draped_scene(4, 1);
  const DrapedScene cloth_only = flat_scene();
  CHECK(Renderer(cloth_only.topology, small_options()).render(cloth_only.frame).pixels.size() ==
        3 * 320 * 180);
  FrameTopology bodies = scene.topology;
  bodies.triangles.resize(0, 3);
  bodies.corner_uv.resize(0, 2);
  bodies.cloth_of_triangle.clear();
  bodies.cloth_of_vertex.clear();
  bodies.cloth_names.clear();
  scene.frame.positions.resize(0, 3);
  scene.frame.contact.clear();
  Renderer renderer(bodies, small_options());
  CHECK(renderer.render(scene.frame).pixels.size() == 3 * 320 * 180);
  Renderer empty(FrameTopology{}, small_options());
  CHECK(empty.render(Frame{}).width == 320);
}

TEST_CASE("pictures have the size that was asked for, odd ones too", "[renderer]") {
  const DrapedScene scene = draped_scene(8, 1);
  for (const auto& [width, height] : {std::pair{16, 16}, {33, 47}, {101, 20}, {640, 360}}) {
    RenderOptions options;
    options.width = width;
    options.height = height;
    options.color_by = "stretch";
    const Image image = Renderer(scene.topology, options).render(scene.frame);
    CHECK(image.width == width);
    CHECK(image.height == height);
    CHECK(image.pixels.size() == 3 * static_cast<std::size_t>(width * height));
  }
}

TEST_CASE(
    "a split picture is that of weft strain on the left half of the cloth and that of warp strain "
    "on the right",
    "[renderer]") {
  DrapedScene scene = flat_scene();
  scene.frame.strain.rowwise() = Eigen::RowVector3d(0.1, 0.3, 0.2);
  RenderOptions options = small_options();
  options.color_low = 0.0, options.color_high = 0.5;
  options.camera.eye = Vec3(0, -1, 0), options.camera.target = Vec3::Zero();
  const auto drawn = [&](const std::string& color_by) {
    options.color_by = color_by;
    return Renderer(scene.topology, options).render(scene.frame);
  };
  const Image weft = drawn("strain_weft"), warp = drawn("strain_warp"),
              split = drawn("strain_split");
  const auto differing = [&](const Image& a, const Image& b, int from, int to) {
    std::size_t count = 0;
    for (int y = 0; y < a.height; ++y)
      for (int x = from; x < to; ++x) {
        const std::size_t at = 3 * (static_cast<std::size_t>(y) * a.width + x);
        count += !std::equal(&a.pixels[at], &a.pixels[at] + 3, &b.pixels[at]);
      }
    return count;
  };
  const int middle = options.width / 2, line = 3;
  CHECK(differing(weft, warp, 0, options.width) > 1000);
  CHECK(differing(split, weft, 0, middle - line) == 0);
  CHECK(differing(split, warp, middle + line, options.width) == 0);
  CHECK(differing(split, warp, 0, middle - line) > 500);
}

TEST_CASE("pictures joined by + lie one below another, each as if alone", "[renderer]") {
  const DrapedScene scene = draped_scene(8, 1);
  RenderOptions options = small_options();
  std::vector<std::uint8_t> rows;
  for (const char* name : {"cloth", "strain_split", "strain_shear"}) {
    options.color_by = name;
    const Image image = Renderer(scene.topology, options).render(scene.frame);
    rows.insert(rows.end(), image.pixels.begin(), image.pixels.end());
  }
  options.color_by = "cloth+strain_split+strain_shear";
  const Image image = Renderer(scene.topology, options).render(scene.frame);
  CHECK(image.width == options.width);
  CHECK(image.height == 3 * options.height);
  CHECK(image.pixels == rows);
}
