// Tests of PNG files, OSMesa and EGL, and several renderers at once.
#include <catch2/catch.hpp>

#include <png.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <thread>

#include "core/base/error.h"
#include "tests/renderer/draped_scene.h"

using namespace loomstone;
using Catch::Matchers::Contains;

namespace {

// A new directory, which the destructor removes.
struct Folder {
  std::filesystem::path path = std::filesystem::temp_directory_path() /
                               ("loomstone_test_renderer_" + std::to_string(getpid()));
  Folder() { std::filesystem::create_directories(path); }
  ~Folder() { std::filesystem::remove_all(path); }
};

Image read_png(const std::string& path) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  REQUIRE(png_image_begin_read_from_file(&header, path.c_str()) != 0);
  CHECK(header.format == PNG_FORMAT_RGB);
  Image image{static_cast<int>(header.width), static_cast<int>(header.height), 3, {}};
  image.pixels.resize(PNG_IMAGE_SIZE(header));
  REQUIRE(png_image_finish_read(&header, nullptr, image.pixels.data(), 0, nullptr) != 0);
  return image;
}

// Sets LOOMSTONE_GL. The destructor unsets it.
struct Forced {
  explicit Forced(const char* backend) { setenv("LOOMSTONE_GL", backend, 1); }
  ~Forced() { unsetenv("LOOMSTONE_GL"); }
};

// Creates a renderer with the backend "osmesa" or "egl". Returns null if this machine cannot use
// it.
std::unique_ptr<Renderer> renderer_by(const char* backend, const DrapedScene& scene) {
  const Forced forced(backend);
  try {
    return std::make_unique<Renderer>(scene.topology, small_options());
  } catch (const Unsupported&) {
    return nullptr;
  }
}

}  // namespace

TEST_CASE("a picture is the same after a PNG file, to the last bit", "[renderer]") {
  const Folder folder;
  const DrapedScene scene = draped_scene(10, 1);
  const Image image = Renderer(scene.topology, small_options()).render(scene.frame);
  const std::string path = folder.path / "picture.png";
  write_png(path, image);
  write_png(path, image);  // overwrites the file
  const Image back = read_png(path);
  CHECK(back.width == image.width);
  CHECK(back.height == image.height);
  CHECK(back.pixels == image.pixels);
  // No partial file is left.
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path), {}) == 1);
}

TEST_CASE("a PNG file that cannot be written is an error that names it", "[renderer]") {
  const Image image{16, 16, 3, std::vector<std::uint8_t>(3 * 256, 7)};
  CHECK_THROWS_AS(write_png("/nowhere/at/all/picture.png", image), CacheError);
  CHECK_THROWS_WITH(write_png("/nowhere/at/all/picture.png", image),
                    Contains("/nowhere/at/all/picture.png"));
  const Folder folder;
  std::filesystem::create_directories(folder.path / "picture.png" / "full");
  // The file cannot be created, because a directory has its name.
  CHECK_THROWS_AS(write_png(folder.path / "picture.png", image), CacheError);
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path), {}) == 1);
  CHECK_THROWS_AS(write_png(folder.path / "a.png", Image{16, 16, 3, {}}), InvalidInput);
  CHECK_THROWS_WITH(write_png(folder.path / "a.png", Image{16, 16, 3, {}}),
                    Contains("3 or 4 bytes for each"));
}

TEST_CASE("OSMesa and EGL draw the same bits, also side by side in one process", "[renderer]") {
  const DrapedScene scene = draped_scene(20, 2);
  const std::unique_ptr<Renderer> osmesa = renderer_by("osmesa", scene),
                                  egl = renderer_by("egl", scene);
  if (osmesa) CHECK(osmesa->backend() == "osmesa");
  if (egl) CHECK(egl->backend() == "egl");
  REQUIRE((osmesa || egl));
  if (!osmesa || !egl) {
    WARN("only one of OSMesa and EGL is installed here; not compared");
    return;
  }
  CHECK(n_different(osmesa->render(scene.frame), egl->render(scene.frame)) == 0);
}

TEST_CASE("LOOMSTONE_GL takes the name of a library and nothing else", "[renderer]") {
  const DrapedScene scene = draped_scene(4, 0);
  const Forced forced("vulkan");
  CHECK_THROWS_AS(Renderer(scene.topology, small_options()), InvalidInput);
  CHECK_THROWS_WITH(Renderer(scene.topology, small_options()),
                    Contains("must be osmesa, egl or softpipe, got 'vulkan'"));
}

// The next test runs this one in a separate process.
TEST_CASE("without OSMesa and EGL the error names the packages", "[.without_libraries]") {
  const DrapedScene scene = draped_scene(4, 0);
  CHECK_THROWS_AS(Renderer(scene.topology, small_options()), Unsupported);
  CHECK_THROWS_WITH(Renderer(scene.topology, small_options()), Contains("neither OSMesa nor EGL") &&
                                                                   Contains("libosmesa6") &&
                                                                   Contains("libegl1"));
  const Forced forced("egl");
  CHECK_THROWS_WITH(Renderer(scene.topology, small_options()),
                    Contains("egl (LOOMSTONE_GL) could not be loaded"));
}

TEST_CASE("a machine that has neither OSMesa nor EGL gets a sentence", "[renderer]") {
  // Empty files with the libraries' names come first on the loader's path, so loading fails as if
  // the libraries were absent.
  const Folder folder;
  for (const char* name :
       {"libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so", "libEGL.so.1", "libEGL.so"})
    std::ofstream(folder.path / name).flush();
  const std::string self = std::filesystem::read_symlink("/proc/self/exe");
  const std::string command = "LD_LIBRARY_PATH='" + folder.path.string() + "' '" + self +
                              "' '[.without_libraries]'" + " > '" +
                              (folder.path / "output").string() + "'";
  const int status = std::system(command.c_str());
  std::ifstream output(folder.path / "output");
  INFO(std::string(std::istreambuf_iterator<char>(output), {}));
  CHECK(status == 0);
}

TEST_CASE("several renderers alive at once do not disturb one another", "[renderer]") {
  const DrapedScene draped = draped_scene(20, 2), flat = flat_scene();
  RenderOptions other = small_options();
  other.width = 200;
  other.pattern = ClothPattern::Checker;
  const Image image = Renderer(draped.topology, small_options()).render(draped.frame);
  const Image other_image = Renderer(flat.topology, other).render(flat.frame);
  Renderer a(draped.topology, small_options()), b(flat.topology, other);
  for (int i = 0; i < 2; ++i) {
    CHECK(n_different(image, a.render(draped.frame)) == 0);
    CHECK(n_different(other_image, b.render(flat.frame)) == 0);
  }
}

TEST_CASE(
    "renderers in several threads, and one handed from thread to thread, draw the same picture",
    "[renderer]") {
  const DrapedScene scene = draped_scene(20, 2);
  Renderer shared(scene.topology, small_options());
  const Image reference = shared.render(scene.frame);
  std::vector<Image> images(3);
  std::vector<std::thread> threads;
  for (Image& image : images) {
    threads.emplace_back([&] {
      Renderer renderer(scene.topology, small_options());
      for (int i = 0; i < 3; ++i) image = renderer.render(scene.frame);
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const Image& image : images) CHECK(n_different(reference, image) == 0);
  Image elsewhere;
  std::thread([&] { elsewhere = shared.render(scene.frame); }).join();
  CHECK(n_different(reference, elsewhere) == 0);
}
