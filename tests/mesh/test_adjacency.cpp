#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <set>

#include "core/base/error.h"
#include "core/mesh/adjacency.h"
#include "core/mesh/generators.h"

namespace loomstone {

TEST_CASE("edges are unique, sorted, and lie opposite the corner they are listed under") {
  const TriangleMesh mesh = jittered_grid(1.0, 1.0, 7, 5, 0.2);
  const EdgeTable table = edge_table(mesh.n_vertices(), mesh.triangles());
  CHECK(table.edges.rows() == 3 * 7 * 5 + 7 + 5);
  for (Eigen::Index e = 0; e < table.edges.rows(); ++e) {
    CHECK(table.edges(e, 0) < table.edges(e, 1));
    if (e > 0) {
      CHECK(std::make_pair(table.edges(e - 1, 0), table.edges(e - 1, 1)) <
            std::make_pair(table.edges(e, 0), table.edges(e, 1)));
    }
    const auto [first, second] = table.triangles[static_cast<std::size_t>(e)];
    CHECK(first >= 0);
    CHECK((second == -1 || first < second));
  }
  for (Index t = 0; t < mesh.n_triangles(); ++t) {
    for (int c = 0; c < 3; ++c) {
      const Index e = table.of_triangle[static_cast<std::size_t>(t)][static_cast<std::size_t>(c)];
      const Index a = mesh.triangles()(t, (c + 1) % 3), b = mesh.triangles()(t, (c + 2) % 3);
      CHECK(table.edges(e, 0) == std::min(a, b));
      CHECK(table.edges(e, 1) == std::max(a, b));
      const auto [first, second] = table.triangles[static_cast<std::size_t>(e)];
      CHECK((first == t || second == t));
    }
  }
}

TEST_CASE(
    "a hinge lists (x1, x3, x4) and (x2, x4, x3) counter-clockwise, as its two triangles do") {
  const TriangleMesh mesh = icosphere(1.0, 1);
  const EdgeTable table = edge_table(mesh.n_vertices(), mesh.triangles());
  const std::vector<Hinge> all = hinges(mesh.triangles(), table);
  CHECK(static_cast<Eigen::Index>(all.size()) == table.edges.rows());
  const auto is_rotation = [&](Index t, std::array<Index, 3> corners) {
    for (int turn = 0; turn < 3; ++turn) {
      if (mesh.triangles()(t, 0) == corners[0] && mesh.triangles()(t, 1) == corners[1] &&
          mesh.triangles()(t, 2) == corners[2]) {
        return true;
      }
      std::rotate(corners.begin(), corners.begin() + 1, corners.end());
    }
    return false;
  };
  for (const Hinge& hinge : all) {
    const auto [x1, x2, x3, x4] = hinge.vertices;
    CHECK(is_rotation(hinge.triangles[0], {x1, x3, x4}));
    CHECK(is_rotation(hinge.triangles[1], {x2, x4, x3}));
    CHECK(hinge.triangles[0] < hinge.triangles[1]);
    CHECK(std::min(x3, x4) == table.edges(hinge.edge, 0));
    CHECK(std::max(x3, x4) == table.edges(hinge.edge, 1));
  }
}

TEST_CASE("an open mesh has one hinge per interior edge") {
  const TriangleMesh mesh = grid_cells(1.0, 1.0, 4, 3);
  const EdgeTable table = edge_table(mesh.n_vertices(), mesh.triangles());
  const auto interior =
      std::count_if(table.triangles.begin(), table.triangles.end(),
                    [](const std::array<Index, 2>& pair) { return pair[1] >= 0; });
  CHECK(static_cast<std::ptrdiff_t>(hinges(mesh.triangles(), table).size()) == interior);
  CHECK(interior == table.edges.rows() - 2 * (4 + 3));
}

TEST_CASE("incidence lists are ascending and agree with a search of the triangle array") {
  const TriangleMesh mesh = disc(1.0, 4);
  const Incidence triangles = triangles_of_vertices(mesh.n_vertices(), mesh.triangles());
  const Incidence graph = vertex_graph(mesh.n_vertices(), mesh.triangles());
  for (Index v = 0; v < mesh.n_vertices(); ++v) {
    std::vector<Index> around;
    std::set<Index> neighbours;
    for (Index t = 0; t < mesh.n_triangles(); ++t) {
      if ((mesh.triangles().row(t).array() == v).any()) {
        around.push_back(t);
        for (int c = 0; c < 3; ++c) neighbours.insert(mesh.triangles()(t, c));
      }
    }
    neighbours.erase(v);
    const auto list = [v](const Incidence& lists) {
      return std::vector<Index>(lists.items.begin() + lists.start[static_cast<std::size_t>(v)],
                                lists.items.begin() + lists.start[static_cast<std::size_t>(v) + 1]);
    };
    CHECK(list(triangles) == around);
    CHECK(list(graph) == std::vector<Index>(neighbours.begin(), neighbours.end()));
  }
}

TEST_CASE("an edge table refuses an edge with three triangles and indices outside the vertices") {
  Triangles fan(3, 3);
  fan << 0, 1, 2, 1, 0, 3, 0, 1, 4;
  CHECK_THROWS_WITH(edge_table(5, fan), Catch::Contains("edge (0, 1) has more: 0, 1, 2"));
  CHECK_THROWS_WITH(edge_table(4, fan.topRows(1).eval() * 2), Catch::Contains("vertices 0 to 3"));
}

}  // namespace loomstone
