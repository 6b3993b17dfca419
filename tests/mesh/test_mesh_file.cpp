#include <catch2/catch.hpp>

#include <bit>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

#include "core/base/error.h"
#include "core/mesh/generators.h"
#include "core/mesh/mesh_file.h"

namespace loomstone {
namespace {

using Catch::Contains;
namespace fs = std::filesystem;

// A new directory, removed at the end of the test.
struct Folder {
  fs::path path =
      fs::temp_directory_path() / ("loomstone_mesh_" + std::to_string(std::random_device{}()));
  Folder() { fs::create_directories(path); }
  ~Folder() { fs::remove_all(path); }

  std::string file(const std::string& name) const { return (path / name).string(); }
  std::string file(const std::string& name, const std::string& content) const {
    std::ofstream(file(name), std::ios::binary) << content;
    return file(name);
  }
};

std::string content_of(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

// A curved mesh of two panels that meet along a welded seam. The coordinates use all digits of a
// double.
TriangleMesh two_panels() {
  const TriangleMesh flat = jittered_grid(1.0 / 3.0, 0.1, 6, 3, 0.2);
  Points vertices = flat.vertices();
  for (Eigen::Index i = 0; i < vertices.rows(); ++i)
    vertices(i, 2) = std::sin(7.0 * vertices(i, 0)) * 1e-7;
  Points2 uv(2 * vertices.rows(), 2);
  uv << flat.uv(), flat.uv();
  uv.bottomRows(vertices.rows()).col(0).array() += M_PI;
  Triangles uv_triangles = flat.triangles();
  for (Index t = 0; t < flat.n_triangles(); ++t) {
    // The cells of the right half form the second panel.
    if (t / 2 % 6 >= 3) uv_triangles.row(t).array() += flat.n_vertices();
  }
  return TriangleMesh(vertices, flat.triangles(), uv, uv_triangles);
}

// Bitwise comparison, which includes the signs of zeros.
template <class Array>
bool same_bits(const Array& a, const Array& b) {
  if (a.rows() != b.rows()) return false;
  for (Eigen::Index i = 0; i < a.size(); ++i) {
    if (std::bit_cast<std::uint64_t>(a.data()[i]) != std::bit_cast<std::uint64_t>(b.data()[i]))
      return false;
  }
  return true;
}

Points2 uv_of_corners(const TriangleMesh& mesh) {
  Points2 result(mesh.has_uv() ? 3 * mesh.n_triangles() : 0, 2);
  for (Index t = 0; mesh.has_uv() && t < mesh.n_triangles(); ++t) {
    for (int c = 0; c < 3; ++c) result.row(3 * t + c) = mesh.uv().row(mesh.uv_triangles()(t, c));
  }
  return result;
}

const std::string ascii_square =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float "
    "z\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 "
    "0\n4 0 1 2 3\n";

}  // namespace

TEST_CASE("OBJ and PLY give back the same bits, panels and their seams included") {
  const Folder folder;
  const std::string obj = folder.file("mesh.obj"), ply = folder.file("mesh.ply"),
                    text = folder.file("text.PLY");
  for (const TriangleMesh& mesh :
       {two_panels(), jittered_grid(1.0, 1.0, 5, 5, 0.1), icosphere(0.1, 2)}) {
    write_mesh(obj, mesh);
    write_mesh(ply, mesh);
    write_mesh(text, mesh, true);
    for (const std::string& path : {obj, ply, text}) {
      INFO(path);
      const TriangleMesh back = read_mesh(path);
      CHECK(same_bits(back.vertices(), mesh.vertices()));
      CHECK(back.triangles() == mesh.triangles());
      CHECK(back.has_uv() == mesh.has_uv());
      CHECK(same_bits(uv_of_corners(back), uv_of_corners(mesh)));
      CHECK_FALSE(read_mesh(path, false).has_uv());
    }
    CHECK(read_mesh(obj).uv_triangles() == mesh.uv_triangles());
    // No temporary files remain.
    CHECK(std::distance(fs::directory_iterator(folder.path), fs::directory_iterator()) == 3);
  }
}

TEST_CASE(
    "OBJ: convex polygons are cut into fans, negative indices count back, all corner forms and odd "
    "lines "
    "are read") {
  const Folder folder;
  const std::string path = folder.file(
      "mesh.obj",
      "# comment\r\nmtllib none.mtl\r\no thing\r\n"
      "v 0 0 0 1 0 0\r\nv +1 0. 0\r\nv 1e0 1 0\r\n\tv 0 1 -0\r\nv 2 0 0\r\nv 2 \\\r\n 1 0\r\n"
      "vn 0 0 1\r\nvt 0 0\r\nf 1//1 2//1 3//1 4//1\r\nf -5/ -2 -1 -4 # quad\r\ng x\r\nl 1 2\r\n");
  const TriangleMesh mesh = read_mesh(path);
  Triangles expected(4, 3);
  expected << 0, 1, 2, 0, 2, 3, 1, 4, 5, 1, 5, 2;
  CHECK(mesh.triangles() == expected);
  CHECK(mesh.vertices().row(5) == Eigen::RowVector3d(2, 1, 0));
  CHECK_FALSE(mesh.has_uv());  // no face refers to a vt
  const std::string marked =
      folder.file("marked.obj", "\xEF\xBB\xBFv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  CHECK(read_mesh(marked).n_vertices() == 3);  // the first line begins with a byte-order mark
}

TEST_CASE("concave faces of OBJ and PLY files are covered once, and keep their uv") {
  const Folder folder;
  // A face in the shape of an L. A fan of triangles around its first corner would not cover it.
  const std::string corners = "2 0 0\n2 1 0\n1 1 0\n1 2 0\n0 2 0\n0 0 0\n";
  std::string obj = "f 1/1 2/2 3/3 4/4 5/5 6/6\n", line;
  std::istringstream lines(corners);
  while (std::getline(lines, line)) obj += "v " + line + "\nvt " + line + "\n";
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float "
      "z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n" +
      corners + "6 0 1 2 3 4 5\n";
  for (const std::string& path : {folder.file("l.obj", obj), folder.file("l.ply", ply)}) {
    const TriangleMesh mesh = read_mesh(path);
    REQUIRE(mesh.n_triangles() == 4);
    double area = 0.0;
    for (const auto& t : mesh.triangles().rowwise()) {
      const Vec3 a = mesh.vertices().row(t[0]), b = mesh.vertices().row(t[1]),
                 c = mesh.vertices().row(t[2]);
      CHECK((b - a).cross(c - a).z() > 0.0);
      area += 0.5 * (b - a).cross(c - a).z();
    }
    CHECK(area == Approx(3.0));
    if (mesh.has_uv()) CHECK(mesh.uv_triangles() == mesh.triangles());
  }
  CHECK_THROWS_WITH(
      read_mesh(folder.file("crossed.obj",
                            "v 0 0 0\nv 3 0 0\nv 1 1 0\nv 2 1.2 0\nv 0 -1 0\nf 1 2 3 4 5\n")),
      Catch::Contains("crossed.obj, line 6: the outline of a face must not cross itself"));
}

TEST_CASE("malformed OBJ files are refused with file and line") {
  const Folder folder;
  const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
  const auto message_of = [&](const std::string& content) -> std::string {
    try {
      read_mesh(folder.file("bad.obj", content));
    } catch (const CacheError& error) {
      return error.what();
    }
    return "no CacheError";
  };
  CHECK_THAT(message_of("v 0 0 0\nv 1 zero 0\n"),
             Contains("bad.obj, line 2") && Contains("\"zero\" as number 2"));
  CHECK_THAT(message_of("v 0 0 +-5\n"), Contains("\"+-5\" as number 3"));
  CHECK_THAT(message_of("v 0 0\n"), Contains("line 1: a vertex must have 3 numbers"));
  CHECK_THAT(message_of("vt 1\n"), Contains("line 1: a vt must have 2 numbers"));
  CHECK_THAT(message_of(square + "f 1 2\n"),
             Contains("line 5: a face must have at least 3 corners, got 2"));
  CHECK_THAT(message_of(square + "f 1 2 0\n"), Contains("line 5") && Contains("got \"0\""));
  CHECK_THAT(message_of(square + "f 1 2 -5\n"), Contains("line 5") && Contains("got \"-5\""));
  CHECK_THAT(message_of(square + "f 1 2 3x\n"), Contains("line 5") && Contains("got \"3x\""));
  CHECK_THAT(
      message_of(square + "f 1 2 3\nf 1 3 7\n"),
      Contains("line 6: a face refers to v 7, but the file has only 4") && Contains("cut short"));
  CHECK_THAT(message_of(square + "vt 0 0\nvt 1 0\nvt 1 1\nf 1/1 2/2 3/3\nf 1 3 4\n"),
             Contains("line 9: either all corners must have a vt or none"));
  CHECK_THAT(message_of(square + "vt 0 0\nf 1/1 2/1 3/2\n"),
             Contains("line 6: a face refers to vt 2"));
}

TEST_CASE("a mesh in a file that breaks a rule is refused with file and item") {
  const Folder folder;
  const std::string path = folder.file("bad.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 5 5 5\nf 1 2 3\n");
  CHECK_THROWS_AS(read_mesh(path), InvalidInput);
  CHECK_THROWS_WITH(read_mesh(path), Contains("bad.obj: vertex 3 must belong to a triangle"));
  CHECK_THROWS_WITH(read_mesh(folder.file("nan.obj", "v 0 0 0\nv 1 nan 0\nv 1 1 0\nf 1 2 3\n")),
                    Contains("nan.obj: vertex 1 must have finite coordinates"));
  CHECK_THROWS_WITH(read_mesh(folder.file("empty.obj", "")),
                    Contains("empty.obj: a mesh must have vertices"));
}

TEST_CASE(
    "texture coordinates of zero area are refused with their triangle, and ignored if not "
    "requested") {
  const Folder folder;
  const std::string path =
      folder.file("odd.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nf 1/1 2/1 3/1\n");
  CHECK_THROWS_WITH(read_mesh(path), Contains("odd.obj: triangle 0 has zero rest area in uv"));
  CHECK(read_mesh(path, false).n_triangles() == 1);
}

TEST_CASE(
    "PLY: polygons, float types, other elements and properties, and big-endian files are read") {
  const Folder folder;
  CHECK(read_mesh(folder.file("square.ply", ascii_square)).n_triangles() == 2);
  std::string header =
      "ply\r\nformat ascii 1.0\r\ncomment x\r\nelement material 2\r\nproperty int a\r\nproperty "
      "list uchar short b\r\n"
      "element vertex 3\r\nproperty float z\r\nproperty uchar red\r\nproperty float x\r\nproperty "
      "float y\r\n"
      "property float u\r\nproperty float v\r\nelement face 1\r\nproperty uchar flags\r\n"
      "property list uint8 uint32 vertex_index\r\nend_header\r\n";
  const TriangleMesh mesh = read_mesh(folder.file(
      "odd.ply",
      header +
          "1 0\r\n2 3 4 5 6\r\n7 255 0 0 0 0\r\n7 255 1 0 1 0\r\n7 255 1 1 1 1\r\n9 3 0 1 2\r\n"));
  CHECK(mesh.vertices().row(2) == Eigen::RowVector3d(1, 1, 7));
  CHECK(mesh.uv().row(2) == Eigen::RowVector2d(1, 1));

  std::string big =
      "ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty short x\nproperty short "
      "y\nproperty short z\n"
      "element face 1\nproperty list uchar ushort vertex_indices\nend_header\n";
  for (const int value : {0, 0, 0, 256, 0, 0, 0, -2, 1}) {
    big += static_cast<char>((value >> 8) & 255);
    big += static_cast<char>(value & 255);
  }
  for (const int byte : {3, 0, 0, 0, 1, 0, 2}) big += static_cast<char>(byte);
  CHECK(read_mesh(folder.file("big.ply", big)).vertices().bottomRows(2) ==
        (Points(2, 3) << 256, 0, 0, 0, -2, 1).finished());
}

TEST_CASE("a PLY file truncated anywhere is refused, never read as a smaller mesh") {
  const Folder folder;
  const std::string whole_path = folder.file("whole.ply");
  for (const bool text : {false, true}) {
    write_mesh(whole_path, two_panels(), text);
    const std::string whole = content_of(whole_path);
    // A text file that lacks only its last line break or its last digits is still valid, so text
    // files are cut earlier.
    for (std::size_t length = 0; length < whole.size() - (text ? 25 : 0);
         length += length < 400 ? 7 : 101) {
      INFO(length);
      CHECK_THROWS_AS(read_mesh(folder.file("cut.ply", whole.substr(0, length))), CacheError);
    }
  }
  write_mesh(whole_path, two_panels());
  const std::string whole = content_of(whole_path);
  CHECK_THROWS_WITH(read_mesh(folder.file("cut.ply", whole.substr(0, whole.size() - 1))),
                    Contains("cut.ply: the file ends in face 35 of 36 (cut short)"));
}

TEST_CASE("malformed PLY files are refused with file and position") {
  const Folder folder;
  const auto message_of = [&](const std::string& from, const std::string& to) -> std::string {
    std::string content = ascii_square;
    content.replace(content.find(from), from.size(), to);
    try {
      read_mesh(folder.file("bad.ply", content));
    } catch (const CacheError& error) {
      return error.what();
    }
    return "no CacheError";
  };
  CHECK_THAT(message_of("ply", "plx"),
             Contains("bad.ply, line 1: a PLY file must begin with \"ply\""));
  CHECK_THAT(message_of("format ascii 1.0\n", ""), Contains("the header must state a format"));
  CHECK_THAT(message_of("ascii", "zip"), Contains("line 2: the format must be ascii"));
  CHECK_THAT(message_of("element vertex 4", "element vertex -4"),
             Contains("line 3: an element must have"));
  CHECK_THAT(message_of("element vertex 4", "element vertex 4000000000"),
             Contains("count below 2^31"));
  CHECK_THAT(message_of("element vertex 4", "what 4"), Contains("the header must consist of"));
  CHECK_THAT(message_of("element vertex 4\n", ""), Contains("a property must follow an element"));
  CHECK_THAT(message_of("property float x", "property real x"),
             Contains("line 4: a property must have a known type"));
  CHECK_THAT(message_of("uchar int", "uchar float"), Contains("vertex indices must be integers"));
  CHECK_THAT(message_of("property float z\n", ""),
             Contains("must declare element vertex with x, y and z"));
  CHECK_THAT(message_of("vertex_indices", "corners"), Contains("must declare element face"));
  CHECK_THAT(message_of("end_header", "comment"), Contains("header must"));
  CHECK_THAT(message_of("1 1 0", "1 one 0"),
             Contains("vertex 2: a value must be a number, got \"one\""));
  CHECK_THAT(message_of("4 0 1 2 3", "2 0 1"),
             Contains("face 0: a face must have at least 3 corners, got 2"));
  CHECK_THAT(message_of("4 0 1 2 3", "-1 0 1"),
             Contains("face 0: a list must have a whole number of items"));
  CHECK_THAT(message_of("4 0 1 2 3", "3 0 1 -2"),
             Contains("face 0: a corner must be the index of a vertex"));
  CHECK_THAT(message_of("4 0 1 2 3", "3 0 1 4"),
             Contains("a face refers to vertex 4, but the file has only 4"));
  const std::string uv_header =
      "property list uchar int vertex_indices\nproperty list uchar float texcoord\n";
  CHECK_THAT(message_of("property list uchar int vertex_indices\n", uv_header),
             Contains("cut short"));
  std::string content = ascii_square + "6 0 0 1 0 1 1\n";
  content.replace(content.find("property list uchar int vertex_indices\n"), 39, uv_header);
  CHECK_THROWS_WITH(read_mesh(folder.file("bad.ply", content)),
                    Contains("texcoord must have 2 numbers per corner, got 6"));
  content = ascii_square + "8 0 0 1 0 1 1 0 nan\n";
  content.replace(content.find("property list uchar int vertex_indices\n"), 39, uv_header);
  CHECK_THROWS_WITH(read_mesh(folder.file("bad.ply", content)),
                    Contains("texcoord must be finite"));
}

TEST_CASE("files that are missing, unwritable or of another kind are refused by name") {
  const Folder folder;
  CHECK_THROWS_AS(read_mesh(folder.file("none.obj")), CacheError);
  CHECK_THROWS_WITH(read_mesh(folder.file("none.obj")),
                    Contains("none.obj cannot be opened: No such file"));
  fs::create_directories(folder.path / "folder.ply");
  CHECK_THROWS_AS(read_mesh(folder.file("folder.ply")), CacheError);
  CHECK_THROWS_AS(read_mesh(folder.file("mesh.stl")), Unsupported);
  CHECK_THROWS_WITH(write_mesh(folder.file("mesh.stl"), icosphere(1.0, 0)),
                    Contains("must end in .obj or .ply"));
  CHECK_THROWS_WITH(write_mesh(folder.file("no/such/mesh.obj"), icosphere(1.0, 0)),
                    Contains("cannot be opened"));
  CHECK_THROWS_WITH(write_mesh(folder.file("folder.ply"), icosphere(1.0, 0)),
                    Contains("cannot be replaced"));
  CHECK_FALSE(fs::exists(folder.path / "folder.ply.partial"));
}

TEST_CASE(
    "a garment loads with the rest coordinates of its pattern, and obstacles with odd ones load "
    "without") {
  const fs::path meshes = fs::path(LOOMSTONE_SHARED_DATA) / "meshes";
  if (!fs::exists(meshes)) {
    WARN("example meshes are not here: " << meshes.string());
    return;
  }
  const TriangleMesh dress = read_mesh((meshes / "dress.obj").string());
  CHECK(dress.has_uv());
  double space = 0.0, pattern = 0.0;
  const std::vector<Corners2> rest = rest_corners(dress, true, "dress"),
                              lengths = rest_corners(dress, false, "dress");
  for (std::size_t t = 0; t < rest.size(); ++t) {
    const auto area = [](const Corners2& x) {
      return 0.5 * ((x(1, 0) - x(0, 0)) * (x(2, 1) - x(0, 1)) -
                    (x(2, 0) - x(0, 0)) * (x(1, 1) - x(0, 1)));
    };
    REQUIRE(area(rest[t]) > 0.0);
    pattern += area(rest[t]);
    space += area(lengths[t]);
  }
  CHECK(space / pattern == Approx(1.0).epsilon(0.1));  // the uv are in metres, with little stretch
  for (const char* name : {"dragon.obj", "bunny.obj", "funnel.obj"}) {
    INFO(name);
    CHECK(welded(read_mesh((meshes / name).string(), false)).closed());
  }
}

}  // namespace loomstone
