// What a picture shows.
#include <catch2/catch.hpp>

#include "tests/renderer/draped_scene.h"

using namespace loomstone;

TEST_CASE("the same frame gives the same picture twice, from one renderer and from two", "[renderer]") {
  const DrapedScene scene = draped_scene();
  Renderer first(scene.topology, small_options()), second(scene.topology, small_options());
  const Image image = first.render(scene.frame);
  CHECK(n_different(image, first.render(scene.frame)) == 0);
  CHECK(n_different(image, second.render(scene.frame)) == 0);
}
