// Tests of the panels that cover the surface of a cuboid: their symmetry, number and width.
#include <set>

#include <catch2/catch.hpp>

#include "core/magnetics/sources/flat_panels.h"

using namespace loomstone;

namespace {

// Returns the nonnegative coordinates of the panels' corners along an axis, in ascending order.
std::set<double> edges_along(const std::vector<FlatPanel>& panels, int axis) {
  std::set<double> edges;
  for (const FlatPanel& panel : panels)
    for (const Vec3& corner : panel.corner)
      if (corner[axis] >= 0.0) edges.insert(corner[axis]);
  return edges;
}

std::array<int, 3> cells_of(const Vec3& size, int cells) {
  const std::vector<FlatPanel> panels = cuboid_panels(size, cells, 0.0);
  std::array<int, 3> numbers;
  for (int axis = 0; axis < 3; ++axis)
    numbers[axis] = 2 * static_cast<int>(edges_along(panels, axis).size() - 1);
  return numbers;
}

double widest(const std::set<double>& edges) {
  double width = 0.0;
  for (auto edge = edges.begin(); std::next(edge) != edges.end(); ++edge)
    width = std::max(width, *std::next(edge) - *edge);
  return width;
}

}  // namespace

TEST_CASE("the panels of a cuboid cover its surface and mirror those of an octant") {
  for (const Vec3& size : {Vec3(1, 1, 1), Vec3(3, 2, 0.4), Vec3(0.1, 20, 3)}) {
    for (const double focus : {0.0, 0.3}) {
      const double faces = 2.0 * (size[0] * size[1] + size[1] * size[2] + size[2] * size[0]);
      const std::vector<FlatPanel> panels = cuboid_panels(size, 8, focus);
      double area = 0.0;
      Vec3 sum = Vec3::Zero();
      const std::size_t n = panels.size() / 8;
      for (std::size_t i = 0; i < panels.size(); ++i) {
        area += panels[i].area;
        sum += panels[i].area * panels[i].normal;
        const Vec3 mirror(i / n & 1 ? -1 : 1, i / n & 2 ? -1 : 1, i / n & 4 ? -1 : 1);
        // The centre of a panel and the mirror image of the centre of its counterpart in the first
        // octant differ by rounding, because the corners of the two panels are summed in different
        // orders.
        CHECK((panels[i].centre - panels[i % n].centre.cwiseProduct(mirror)).norm() < 1e-14);
      }
      CHECK(area == Approx(faces));
      CHECK(sum.norm() < 1e-12 * area);
    }
  }
}

TEST_CASE("longer edges of a cuboid have a multiple of the cells of its shortest edge") {
  CHECK(cells_of({1, 1, 1}, 16) == std::array{16, 16, 16});
  CHECK(cells_of({10, 5, 1}, 16) == std::array{64, 48, 16});
  CHECK(cells_of({1, 10, 5}, 12) == std::array{12, 48, 36});
  // The number of panels is limited, so long edges have fewer cells than their length requires.
  CHECK(cells_of({100, 100, 1}, 8) == std::array{24, 24, 8});
  CHECK(cells_of({1, 1e4, 1}, 8) == std::array{8, 72, 8});
}

TEST_CASE("panels of a flat cuboid are narrower than a fifth of its thickness") {
  for (const Vec3& size : {Vec3(1.4, 1.2, 1), Vec3(2.4, 2.4, 1), Vec3(7.5, 5, 1), Vec3(10, 5, 1)})
    for (int axis = 0; axis < 3; ++axis)
      CHECK(widest(edges_along(cuboid_panels(size, 16, 0.0), axis)) < 0.175);
}

TEST_CASE("panels of a very wide cuboid grow towards the middle and are refined at the ends") {
  const std::set<double> edges = edges_along(cuboid_panels({100, 100, 1}, 16, 0.0), 0);
  CHECK(50.0 - *std::next(edges.begin(), edges.size() - 2) < 0.02);
  double last = 1e300;
  for (auto edge = edges.begin(); std::next(edge) != edges.end(); ++edge) {
    CHECK(*std::next(edge) - *edge < last);
    last = *std::next(edge) - *edge;
  }
}
