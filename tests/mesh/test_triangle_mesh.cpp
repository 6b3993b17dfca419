#include <catch2/catch.hpp>

#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/mesh/generators.h"
#include "core/mesh/triangle_mesh.h"

namespace loomstone {
namespace {

using Catch::Contains;

// Two counter-clockwise triangles that form a unit square.
struct Square {
  Points vertices{4, 3};
  Triangles triangles{2, 3};
  Points2 uv{4, 2};

  Square() {
    vertices << 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0;
    triangles << 0, 1, 2, 0, 2, 3;
    uv = vertices.leftCols<2>();
  }
};

template <class Array, class... Values>
Array with_row(const Array& array, Values... values) {
  Array result(array.rows() + 1, array.cols());
  result.topRows(array.rows()) = array;
  result.row(array.rows()) =
      Eigen::Matrix<typename Array::Scalar, 1, Array::ColsAtCompileTime>(values...);
  return result;
}

}  // namespace

TEST_CASE("a valid mesh keeps its arrays as given") {
  const Square square;
  const TriangleMesh plain(square.vertices, square.triangles),
      with_uv(square.vertices, square.triangles, square.uv);
  CHECK(plain.vertices() == square.vertices);
  CHECK(plain.triangles() == square.triangles);
  CHECK_FALSE(plain.has_uv());
  CHECK(with_uv.uv() == square.uv);
  CHECK(with_uv.uv_triangles() == square.triangles);
}

TEST_CASE("an empty mesh is refused") {
  CHECK_THROWS_WITH(TriangleMesh(Points(0, 3), Triangles(0, 3)), Contains("empty mesh"));
  CHECK_THROWS_WITH(TriangleMesh(Square().vertices, Triangles(0, 3)),
                    Contains("4 vertices and 0 triangles"));
  CHECK_THROWS_AS(TriangleMesh(Points(0, 3), Triangles(0, 3)), InvalidInput);
}

TEST_CASE("a vertex with NaN or infinity is named") {
  Square square;
  square.vertices(2, 1) = std::nan("");
  CHECK_THROWS_WITH(TriangleMesh(square.vertices, square.triangles),
                    Contains("vertex 2 must have finite coordinates"));
  square.vertices(2, 1) = std::numeric_limits<double>::infinity();
  CHECK_THROWS_WITH(TriangleMesh(square.vertices, square.triangles), Contains("vertex 2"));
}

TEST_CASE("an index out of range is named with its triangle") {
  Square square;
  square.triangles(1, 2) = 4;
  CHECK_THROWS_WITH(TriangleMesh(square.vertices, square.triangles),
                    Contains("triangle 1 must refer to vertices 0 to 3, got 4"));
  square.triangles(1, 2) = -1;
  CHECK_THROWS_WITH(TriangleMesh(square.vertices, square.triangles), Contains("got -1"));
}

TEST_CASE("a triangle that repeats a vertex or lies on a line is named as having zero area") {
  Square square;
  CHECK_THROWS_WITH(TriangleMesh(square.vertices, with_row(square.triangles, 2, 2, 3)),
                    Contains("triangle 2") && Contains("(2, 2, 3)") && Contains("zero area"));
  // Vertices 0, 4 and 5 are collinear.
  const Points more = with_row(with_row(square.vertices, 0.1, 0.3, 0.0), 0.2, 0.6, 0.0);
  CHECK_THROWS_WITH(TriangleMesh(more, with_row(square.triangles, 0, 4, 5)),
                    Contains("triangle 2 has zero area") && Contains("(0, 4, 5)"));
}

TEST_CASE("a sliver of a millionth of its length and a mesh of micrometres are accepted") {
  Square square;
  square.vertices.col(1) *= 1e-6;
  CHECK_NOTHROW(TriangleMesh(square.vertices, square.triangles));
  CHECK_NOTHROW(TriangleMesh(1e-6 * Square().vertices, square.triangles));
}

TEST_CASE("duplicate faces are named, whatever corner they begin at and however they are wound") {
  const Square square;
  CHECK_THROWS_WITH(TriangleMesh(square.vertices, with_row(square.triangles, 2, 0, 1)),
                    Contains("triangle 2 has the same vertices (2, 0, 1) as triangle 0"));
  CHECK_THROWS_WITH(TriangleMesh(square.vertices, with_row(square.triangles, 3, 2, 0)),
                    Contains("as triangle 1"));
}

TEST_CASE("an edge with three faces is named together with them") {
  const Square square;
  CHECK_THROWS_WITH(
      TriangleMesh(with_row(square.vertices, 0.5, 0.5, 1.0), with_row(square.triangles, 2, 0, 4)),
      Contains("edge (0, 2)") && Contains("triangles 0, 1 and 2") && Contains("non-manifold"));
}

TEST_CASE("an inverted face is named, not one of its neighbours") {
  const TriangleMesh mesh = grid_cells(1.0, 1.0, 4, 4);
  Triangles triangles = mesh.triangles();
  std::swap(triangles(11, 0), triangles(11, 1));  // triangle 11 has three neighbours
  CHECK_THROWS_WITH(TriangleMesh(mesh.vertices(), triangles),
                    Contains("triangle 11 must have the same winding"));
}

TEST_CASE("an isolated vertex is named") {
  const Square square;
  const Points more = with_row(with_row(square.vertices, 2, 2, 2), 3, 3, 3);
  CHECK_THROWS_WITH(
      TriangleMesh(more, square.triangles),
      Contains("vertex 4 must belong to a triangle") && Contains("2 vertices are isolated"));
}

TEST_CASE("two fans that meet in one vertex are accepted") {
  const Square square;
  const Points more = with_row(with_row(square.vertices, 2, 1, 0), 2, 2, 0);
  CHECK_NOTHROW(TriangleMesh(more, with_row(square.triangles, 2, 4, 5)));
}

TEST_CASE("uv that do not fit the mesh are refused by name") {
  const Square square;
  const auto make = [&](const Points2& uv, const Triangles& uv_triangles = {}) {
    return TriangleMesh(square.vertices, square.triangles, uv, uv_triangles);
  };
  CHECK_THROWS_WITH(make(square.uv.topRows(3)),
                    Contains("one row per vertex") && Contains("got 3 rows for 4 vertices"));
  CHECK_THROWS_WITH(make(square.uv, square.triangles.topRows(1)),
                    Contains("uv_triangles must have one row per triangle"));
  CHECK_THROWS_WITH(make({}, square.triangles), Contains("uv_triangles must come with uv"));
  Points2 uv = square.uv;
  uv(3, 0) = std::nan("");
  CHECK_THROWS_WITH(make(uv), Contains("uv 3 must have finite coordinates"));
  Triangles outside = square.triangles;
  outside(1, 1) = 9;
  CHECK_THROWS_WITH(make(square.uv, outside),
                    Contains("triangle 1 must refer to uv 0 to 3, got 9"));
  uv = square.uv;
  uv.row(3) = uv.row(2);
  CHECK_THROWS_WITH(make(uv), Contains("triangle 1 has zero rest area in uv (uv (0, 2, 3)"));
}

TEST_CASE("a triangle folded over in uv is named, a panel mirrored as a whole is accepted") {
  const TriangleMesh mesh = grid_cells(1.0, 1.0, 3, 3);
  Points2 uv = mesh.uv();
  uv.row(0) << 0.5, 0.5;  // moves the uv of vertex 0 to the opposite corner of the grid
  CHECK_THROWS_WITH(
      TriangleMesh(mesh.vertices(), mesh.triangles(), uv),
      Contains("triangle 0 must be oriented in uv like most of its panel") && Contains("inverted"));
  uv = mesh.uv();
  uv.col(0) *= -1.0;
  CHECK_NOTHROW(TriangleMesh(mesh.vertices(), mesh.triangles(), uv));
}

TEST_CASE("uv given corner by corner still form panels where their values agree") {
  const TriangleMesh mesh = grid_cells(1.0, 1.0, 3, 3);
  Points2 uv(3 * mesh.n_triangles(), 2);
  Triangles uv_triangles(mesh.n_triangles(), 3);
  for (Index t = 0; t < mesh.n_triangles(); ++t) {
    for (int c = 0; c < 3; ++c) {
      const Index vertex = mesh.triangles()(t, c);
      uv_triangles(t, c) = 3 * t + c;
      uv.row(3 * t + c) = mesh.uv().row(vertex);
      if (vertex == 0) uv.row(3 * t + c) << 0.5, 0.5;
    }
  }
  CHECK_THROWS_WITH(TriangleMesh(mesh.vertices(), mesh.triangles(), uv, uv_triangles),
                    Contains("triangle 0 must be oriented"));
}

TEST_CASE("welding closes a surface cut along seams and keeps its uv") {
  const TriangleMesh sphere = icosphere(1.0, 1);
  Points torn(3 * sphere.n_triangles(), 3);
  Points2 uv(3 * sphere.n_triangles(), 2);
  Triangles triangles(sphere.n_triangles(), 3);
  for (Index t = 0; t < sphere.n_triangles(); ++t) {
    for (int c = 0; c < 3; ++c) {
      torn.row(3 * t + c) = sphere.vertices().row(sphere.triangles()(t, c));
      uv.row(3 * t + c) << t + (c == 1), (c == 2);
      triangles(t, c) = 3 * t + c;
    }
  }
  const TriangleMesh pieces(torn, triangles, uv), whole = welded(pieces);
  CHECK_FALSE(pieces.closed());
  CHECK(whole.closed());
  CHECK(whole.n_vertices() == sphere.n_vertices());
  CHECK(whole.uv() == uv);
  CHECK(whole.uv_triangles() == triangles);
}

TEST_CASE("panels that meet along a welded seam may have any uv, one of them mirrored") {
  const Square square;
  Points2 uv(6, 2);
  uv << 0, 0, 1, 0, 1, 1, /* second panel, mirrored */ 10, 0, 9, 1, 10, 1;
  Triangles uv_triangles(2, 3);
  uv_triangles << 0, 1, 2, 3, 4, 5;
  const TriangleMesh mesh(square.vertices, square.triangles, uv, uv_triangles);
  CHECK(mesh.uv_triangles() == uv_triangles);
}

TEST_CASE("mean edge, closed and flat are those of the shape") {
  const Square square;
  CHECK(TriangleMesh(square.vertices, square.triangles).mean_edge() ==
        Approx((4.0 + std::sqrt(2.0)) / 5.0));
  CHECK(box(1.0, 1.0, 1.0).closed());
  CHECK_FALSE(grid_cells(1.0, 1.0, 2, 2).closed());
  Points bent = grid_cells(1.0, 1.0, 2, 2).vertices();
  bent(4, 2) = 1e-6;
  CHECK_FALSE(TriangleMesh(bent, grid_cells(1.0, 1.0, 2, 2).triangles()).flat());
  const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  CHECK(grid_cells(1.0, 0.3, 9, 4).moved(Vec3(1, 2, 3), turn).flat());
}

TEST_CASE("a moved mesh keeps its shape and uv, and a matrix that is no rotation is refused") {
  const TriangleMesh mesh = disc(1.0, 3);
  const Mat3 turn = Eigen::AngleAxisd(1.1, Vec3(3, 1, -2).normalized()).toRotationMatrix();
  const TriangleMesh moved = mesh.moved(Vec3(5, 6, 7), turn, 2.0);
  CHECK(moved.mean_edge() == Approx(2.0 * mesh.mean_edge()).epsilon(1e-13));
  CHECK(moved.uv() == mesh.uv());
  CHECK(moved.vertices().row(0) == Eigen::RowVector3d(5, 6, 7));  // vertex 0 starts at the origin
  CHECK_THROWS_WITH(mesh.moved(Vec3::Zero(), 2.0 * Mat3::Identity()),
                    Contains("rotation must be a rotation matrix"));
  CHECK_THROWS_WITH(mesh.moved(Vec3::Zero(), -Mat3::Identity()), Contains("rotation must be"));
  CHECK_THROWS_WITH(mesh.moved(Vec3::Zero(), Mat3::Identity(), 0.0), Contains("scale must be > 0"));
  CHECK_THROWS_WITH(mesh.moved(Vec3(std::nan(""), 0, 0)), Contains("translation must be finite"));
}

TEST_CASE("a reordered mesh has the same triangles and uv at their new positions") {
  const TriangleMesh mesh = jittered_grid(1.0, 1.0, 5, 4, 0.2);
  std::vector<Index> vertex_order, triangle_order;
  // `vertex_order` is a permutation, because 30 and 7 are coprime.
  for (Index i = 0; i < mesh.n_vertices(); ++i)
    vertex_order.push_back((7 * i + 3) % mesh.n_vertices());
  for (Index t = 0; t < mesh.n_triangles(); ++t)
    triangle_order.push_back(mesh.n_triangles() - 1 - t);
  const TriangleMesh other = mesh.reordered(vertex_order, triangle_order);
  for (Index t = 0; t < mesh.n_triangles(); ++t) {
    const Index old = triangle_order[static_cast<std::size_t>(t)];
    for (int c = 0; c < 3; ++c) {
      CHECK(other.vertices().row(other.triangles()(t, c)) ==
            mesh.vertices().row(mesh.triangles()(old, c)));
      CHECK(other.uv().row(other.uv_triangles()(t, c)) ==
            mesh.uv().row(mesh.uv_triangles()(old, c)));
    }
  }
  CHECK_NOTHROW(
      TriangleMesh(other.vertices(), other.triangles(), other.uv(), other.uv_triangles()));
  vertex_order[0] = vertex_order[1];
  CHECK_THROWS_WITH(
      mesh.reordered(vertex_order, triangle_order),
      Contains("vertex_order must be a permutation that holds each index in [0, 30) once"));
  triangle_order.pop_back();
  CHECK_THROWS_AS(mesh.reordered({}, triangle_order), InvalidInput);
}

}  // namespace loomstone
