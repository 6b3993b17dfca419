// Tests of the looks of surfaces, of transparent backgrounds, and of images of surface ids, depths
// and normals.
#include <catch2/catch.hpp>

#include <array>
#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "tests/renderer/draped_scene.h"

using namespace loomstone;

namespace {

constexpr double pi = 3.14159265358979323846;

std::array<int, 4> pixel_with_alpha(const Image& image, int x, int y) {
  const std::size_t channels = static_cast<std::size_t>(image.channels);
  const std::uint8_t* at =
      &image.pixels[channels * (static_cast<std::size_t>(y) * image.width + x)];
  return {at[0], at[1], at[2], channels == 4 ? at[3] : 255};
}

// Options with which the flat square, 0.5 m wide, fills the picture.
RenderOptions square_options() {
  RenderOptions options = small_options();
  options.width = options.height = 128;
  options.pattern = ClothPattern::Plain;
  options.shadows = options.ambient_occlusion = false;
  options.camera.fit = false;
  options.camera.eye = Vec3(0, -1, 0);
  options.camera.field_of_view_degrees = 2.0 * std::atan(0.25) * 180.0 / pi;
  options.light_direction = Vec3(0, -1, 0);
  return options;
}

// Image of two by two pixels: red and green in the upper row, blue and transparent in the lower
// row.
std::shared_ptr<const TextureImage> four_colors() {
  return std::make_shared<const TextureImage>(
      TextureImage{2, 2, {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 0}});
}

// Returns the channel that exceeds both others by more than 60, or -1 if none does. Where the
// texture is red, green or blue, the other channels contain only specular light.
int strongest(const std::array<int, 4>& color) {
  for (int i = 0; i < 3; ++i)
    if (color[i] > color[(i + 1) % 3] + 60 && color[i] > color[(i + 2) % 3] + 60) return i;
  return -1;
}

}  // namespace

TEST_CASE("a surface has the colour of its look", "[renderer]") {
  DrapedScene scene = draped_scene(12, 3);
  scene.topology.body_looks.resize(2);
  scene.topology.cloth_looks.resize(1);
  for (int channel = 0; channel < 3; ++channel) {
    Vec3 color = Vec3::Zero(), other = Vec3::Zero();
    color[channel] = other[(channel + 1) % 3] = 1.0;
    scene.topology.body_looks[0].color = color;
    scene.topology.cloth_looks[0].color = other;
    RenderOptions options = small_options();
    options.pattern = ClothPattern::Plain;
    options.camera.eye = Vec3(0, -1, -0.6);  // from below, the ball is visible
    options.floor = false;
    options.camera.fit = false;
    Renderer renderer(scene.topology, options);
    const Image image = renderer.render(scene.frame);
    const SurfaceImages seen = renderer.surfaces(scene.frame);
    int wrong = 0, balls = 0;
    for (int y = 1; y + 1 < image.height; ++y)
      for (int x = 1; x + 1 < image.width; ++x) {
        const std::size_t at = static_cast<std::size_t>(y) * image.width + x;
        const std::int32_t id = seen.id[at];
        if (id == 0 || id != seen.id[at - 1] || id != seen.id[at + 1] ||
            id != seen.id[at - image.width] || id != seen.id[at + image.width])
          continue;  // edge pixels are blended
        const std::array<int, 4> shown = pixel_with_alpha(image, x, y);
        const int main = (channel + (id == 1)) % 3;
        wrong += shown[main] <= shown[(main + 1) % 3] || shown[main] <= shown[(main + 2) % 3];
        balls += id == 2;
      }
    CHECK(balls > 500);
    CHECK(wrong == 0);
  }
}

TEST_CASE("a texture lies where its uv say, repeats by its width, and shows the color through",
          "[renderer]") {
  DrapedScene scene = flat_scene();
  scene.topology.cloth_looks = {Look{Vec3(0, 0, 0), 1.0, four_colors(), 0.0}};
  {
    const Image image = Renderer(scene.topology, square_options()).render(scene.frame);
    CHECK(strongest(pixel_with_alpha(image, 32, 32)) ==
          0);  // the first row of the texture lies at the upper edge of the cloth
    CHECK(strongest(pixel_with_alpha(image, 96, 32)) == 1);
    CHECK(strongest(pixel_with_alpha(image, 32, 96)) == 2);
    const std::array<int, 4> through = pixel_with_alpha(image, 96, 96);
    CHECK(std::max({through[0], through[1], through[2]}) < 90);  // black, but for specular light
  }
  scene.topology.cloth_looks[0].texture_width = 0.25;
  const Image image = Renderer(scene.topology, square_options()).render(scene.frame);
  for (const int x : {16, 80})
    for (const int y : {16, 80}) {
      CHECK(strongest(pixel_with_alpha(image, x, y)) == 0);
      CHECK(strongest(pixel_with_alpha(image, x + 32, y)) == 1);
      CHECK(strongest(pixel_with_alpha(image, x, y + 32)) == 2);
    }
}

TEST_CASE("a body has a texture by its uv", "[renderer]") {
  // A square of two triangles, as a body. Its texture coordinates cover the whole square with the
  // lower left pixel of the image, which is blue.
  DrapedScene scene;
  scene.topology.corner_uv.resize(0, 2);
  scene.topology.body_names = {"board"};
  scene.topology.body_is_floor = {0};
  scene.topology.body_triangles.resize(2, 3);
  scene.topology.body_triangles << 0, 1, 2, 0, 2, 3;
  scene.topology.body_of_triangle = {0, 0};
  scene.topology.body_of_vertex = {0, 0, 0, 0};
  scene.topology.body_corner_uv.resize(6, 2);
  scene.topology.body_corner_uv << 0.1, 0.1, 0.4, 0.1, 0.4, 0.4, 0.1, 0.1, 0.4, 0.4, 0.1, 0.4;
  scene.topology.body_looks = {Look{{}, {}, four_colors(), 1.0}};
  scene.frame.body_vertices.resize(4, 3);
  scene.frame.body_vertices << -0.2, 0, -0.2, 0.2, 0, -0.2, 0.2, 0, 0.2, -0.2, 0, 0.2;
  const Image image = Renderer(scene.topology, square_options()).render(scene.frame);
  CHECK(strongest(pixel_with_alpha(image, 64, 64)) == 2);
}

TEST_CASE("smooth surfaces have smaller and brighter highlights", "[renderer]") {
  DrapedScene scene = draped_scene(4, 4);
  scene.frame.positions.array() -= 5.0;  // moves the cloth away from the ball
  scene.topology.body_looks.resize(2);
  const auto drawn = [&](double roughness) {
    scene.topology.body_looks[0] = Look{Vec3(0.2, 0.2, 0.2), roughness, {}, 0.0};
    RenderOptions options = square_options();
    options.floor = false;
    const Image image = Renderer(scene.topology, options).render(scene.frame);
    return std::array{pixel_with_alpha(image, 64, 64)[0], pixel_with_alpha(image, 84, 64)[0]};
  };
  const auto [polished, aside] = drawn(0.2);
  const auto [matt, matt_aside] = drawn(1.0);
  CHECK(polished > matt + 60);
  CHECK(std::abs(aside - matt_aside) < 20);
}

TEST_CASE("a floor with a colour shows it, and fades into the backdrop", "[renderer]") {
  DrapedScene scene = draped_scene(8, 1);
  scene.topology.body_looks.resize(2);
  RenderOptions options = small_options();
  options.camera = square_options().camera;
  options.camera.eye = Vec3(0, -1.5, 1.5);
  options.camera.field_of_view_degrees = 60.0;
  const Image plain = Renderer(scene.topology, options).render(scene.frame);
  scene.topology.body_looks[1].color = Vec3(1, 0, 0);
  const Image red = Renderer(scene.topology, options).render(scene.frame);
  CHECK(strongest(pixel_with_alpha(red, 160, 170)) == 0);
  CHECK(strongest(pixel_with_alpha(plain, 160, 170)) == -1);
}

TEST_CASE("without a background, alpha is 0 outside, 1 inside and between them in shadows",
          "[renderer]") {
  const DrapedScene scene = draped_scene(20, 2);
  RenderOptions options = small_options();
  options.background = Background::None;
  Renderer renderer(scene.topology, options);
  const Image image = renderer.render(scene.frame);
  REQUIRE(image.channels == 4);
  const SurfaceImages seen = renderer.surfaces(scene.frame);
  CHECK(pixel_with_alpha(image, 1, 1)[3] == 0);
  CHECK(pixel_with_alpha(image, 318, 1)[3] == 0);
  const auto all_are = [&](int x, int y, std::int32_t id) {  // the pixel and its neighbours
    for (int k = 0; k < 9; ++k)
      if (seen.id[static_cast<std::size_t>(y + k / 3 - 1) * image.width + x + k % 3 - 1] != id)
        return false;
    return true;
  };
  int shadows = 0, cloth = 0, wrong = 0;
  for (int y = 1; y + 1 < image.height; ++y)
    for (int x = 1; x + 1 < image.width; ++x) {
      const std::array<int, 4> shown = pixel_with_alpha(image, x, y);
      if (all_are(x, y, 1)) ++cloth, wrong += shown[3] != 255;
      if (all_are(x, y, 3)) shadows += shown[3] > 40, wrong += shown[3] > 0 && shown[0] > 0;
    }
  CHECK(cloth > 1000);
  CHECK(shadows > 200);
  CHECK(wrong == 0);
}

TEST_CASE("the depth of a plane is its analytic distance along the viewing direction",
          "[renderer]") {
  DrapedScene scene = draped_scene(4, 1);
  RenderOptions options = small_options();
  options.camera.fit = false;
  options.camera.eye = Vec3(0.1, -2.0, 1.0);
  options.camera.target = Vec3(0.0, 0.0, -0.2);
  options.hidden = "ball";
  Renderer renderer(scene.topology, options);
  renderer.fit(scene.frame);
  scene.frame.positions.col(2).array() -= 50.0;  // moves the cloth out of sight
  const SurfaceImages seen = renderer.surfaces(scene.frame);
  const Vec3 forward = (options.camera.target - options.camera.eye).normalized(),
             right = forward.cross(Vec3::UnitZ()).normalized(), up = right.cross(forward);
  const double tangent = std::tan(0.5 * 35.0 * pi / 180.0);
  int floors = 0;
  for (int y = 0; y < seen.height; ++y)
    for (int x = 0; x < seen.width; ++x) {
      const std::size_t at = static_cast<std::size_t>(y) * seen.width + x;
      if (seen.id[at] == 0) {
        CHECK(seen.depth[at] == std::numeric_limits<float>::infinity());
        continue;
      }
      ++floors;
      CHECK(seen.id[at] == 3);  // 1 is the cloth and 2 the hidden ball
      const Vec3 ray =
          forward + tangent * ((x + 0.5 - 160.0) / 90.0 * right + (90.0 - y - 0.5) / 90.0 * up);
      const double depth = (-0.30 - options.camera.eye.z()) / ray.z();
      CHECK(seen.depth[at] == Approx(depth).epsilon(1e-5));  // single precision
      CHECK(seen.normal[3 * at + 2] == Approx(1.0));
    }
  CHECK(floors > 10000);
}

TEST_CASE("normals of a ball point away from its centre, in world axes", "[renderer]") {
  DrapedScene scene = draped_scene(4, 4);
  scene.frame.positions.col(2).array() -= 50.0;
  RenderOptions options = small_options();
  options.camera.fit = false;
  options.camera.eye = Vec3(0.6, -0.7, 0.4);
  options.floor = false;
  const SurfaceImages seen = Renderer(scene.topology, options).surfaces(scene.frame);
  const Vec3 forward = -options.camera.eye.normalized(),
             right = forward.cross(Vec3::UnitZ()).normalized(), up = right.cross(forward);
  const double tangent = std::tan(0.5 * 35.0 * pi / 180.0);
  int pixels = 0;
  for (int y = 0; y < seen.height; ++y)
    for (int x = 0; x < seen.width; ++x) {
      const std::size_t at = static_cast<std::size_t>(y) * seen.width + x;
      if (seen.id[at] != 2) continue;
      ++pixels;
      const Vec3 ray =
          forward + tangent * ((x + 0.5 - 160.0) / 90.0 * right + (90.0 - y - 0.5) / 90.0 * up);
      const Vec3 outwards = (options.camera.eye + seen.depth[at] * ray).normalized();
      const Vec3 normal = Eigen::Vector3f(&seen.normal[3 * at]).cast<double>();
      CHECK(normal.norm() == Approx(1.0));
      CHECK(normal.dot(outwards) > 0.999);  // tolerance of 2.6 degrees: triangles are flat
    }
  CHECK(pixels > 3000);
}
