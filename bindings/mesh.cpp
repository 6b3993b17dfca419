// Binds triangle meshes, functions that generate, read and write them, and queries of surfaces.
#include "core/mesh/triangle_mesh.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include "bindings/bindings.h"
#include "core/base/message.h"
#include "core/mesh/adjacency.h"
#include "core/mesh/generators.h"
#include "core/mesh/mesh_file.h"
#include "core/mesh/polygons.h"
#include "core/mesh/spatial_query.h"

namespace loomstone {

namespace {

std::string repr(const TriangleMesh& mesh) {
  return formatted("TriangleMesh({} vertices, {} triangles{}{})", mesh.n_vertices(),
                   mesh.n_triangles(), mesh.has_uv() ? ", uv" : "",
                   mesh.closed() ? ", closed" : "");
}

bool equal_meshes(const TriangleMesh& a, const TriangleMesh& b) {
  const auto same = [](const auto& x, const auto& y) {
    return x.rows() == y.rows() && (x.rows() == 0 || x == y);
  };
  return same(a.vertices(), b.vertices()) && same(a.triangles(), b.triangles()) &&
         same(a.uv(), b.uv()) && same(a.uv_triangles(), b.uv_triangles());
}

// Converts a trimesh.Trimesh or meshio.Mesh to a TriangleMesh. pybind11 calls this function for an
// argument that must be a TriangleMesh but has another type. Throws for a trimesh.Scene and for
// invalid meshes. Returns null for objects of any other type.
PyObject* converted_mesh(PyObject* object, PyTypeObject*) {
  py::object mesh =
      py::module_::import("loomstone.base.foreign_meshes").attr("converted")(py::handle(object));
  return mesh.is_none() ? nullptr : mesh.release().ptr();
}

void bind_triangle_mesh(py::module_& m) {
  py::classh<TriangleMesh> c(m, "TriangleMesh",
                             "Immutable triangle mesh, validated when it is created.\n"
                             "\n"
                             "vertices : (n x 3) positions [m]\n"
                             "triangles : (m x 3) vertex indices\n"
                             "uv : (k x 2) rest coordinates, weft and warp [m], or None\n"
                             "uv_triangles : (m x 3) indices into uv; None: the same as triangles\n"
                             "\n"
                             "Raises InvalidInput naming the faulty item: NaN, zero area, "
                             "duplicate or inverted faces, non-manifold\n"
                             "edges, isolated vertices, indices out of range.");
  c.def(py::init([](const py::object& vertices, const py::object& triangles, const py::object& uv,
                    const py::object& uv_triangles) {
          return TriangleMesh(as_rows<Points>(vertices, {"vertices", "m"}),
                              as_rows<Triangles>(triangles, "triangles"),
                              uv.is_none() ? Points2() : as_rows<Points2>(uv, {"uv", "m"}),
                              uv_triangles.is_none()
                                  ? Triangles()
                                  : as_rows<Triangles>(uv_triangles, "uv_triangles"));
        }),
        py::arg("vertices"), py::arg("triangles"), py::arg("uv") = py::none(), py::kw_only(),
        py::arg("uv_triangles") = py::none());
  const auto array = [&](const char* name, auto getter, const char* text) {
    c.def_property_readonly(name, getter, py::return_value_policy::reference_internal, text);
  };
  array("vertices", &TriangleMesh::vertices, "(n x 3) positions [m], read-only view");
  array("triangles", &TriangleMesh::triangles, "(m x 3) vertex indices, read-only view");
  array("uv", &TriangleMesh::uv,
        "(k x 2) rest coordinates [m], read-only view; no rows if the mesh has none");
  array("uv_triangles", &TriangleMesh::uv_triangles, "(m x 3) indices into uv, read-only view");
  c.def_property_readonly("n_vertices", &TriangleMesh::n_vertices, "number of vertices");
  c.def_property_readonly("n_triangles", &TriangleMesh::n_triangles, "number of triangles");
  c.def_property_readonly("closed", &TriangleMesh::closed, "True if every edge has two faces");
  c.def_property_readonly("flat", &TriangleMesh::flat, "True if all vertices lie in one plane");
  c.def_property_readonly("mean_edge", &TriangleMesh::mean_edge, "mean length of the edges [m]");
  c.def_property_readonly(
      "edges",
      [](const TriangleMesh& mesh) {
        return edge_table(mesh.n_vertices(), mesh.triangles()).edges;
      },
      "(k x 2) unique edges as (smaller, larger) vertex, sorted");
  c.def(
      "moved",
      [](const TriangleMesh& mesh, const py::object& translation, const py::object& rotation,
         double scale) {
        return mesh.moved(as_vector<Vec3>(translation, {"translation", "m"}),
                          as_rows<Points>(rotation, "rotation", 3), scale);
      },
      py::arg("translation") = py::make_tuple(0, 0, 0), py::kw_only(),
      py::arg("rotation") =
          py::make_tuple(py::make_tuple(1, 0, 0), py::make_tuple(0, 1, 0), py::make_tuple(0, 0, 1)),
      py::arg("scale") = 1.0,
      "Returns a copy with vertices at rotation * scale * x + translation [m] and unchanged uv.\n\n"
      "translation : (3) displacement [m]\nrotation : (3 x 3) rotation matrix\n"
      "scale : factor [1]\n\nRaises InvalidInput for a rotation that stretches or mirrors.");
  c.def("__eq__", &equal_meshes, py::is_operator());
  c.def("__repr__", &repr);
  py::detail::get_type_info(typeid(TriangleMesh))->implicit_conversions.push_back(&converted_mesh);
}

void bind_generators(py::module_& m) {
  m.def("grid_cells", &grid_cells, py::arg("width"), py::arg("height"), py::arg("nx"),
        py::arg("ny"), py::kw_only(), py::arg("pattern") = "alternating",
        "Rectangle of width x height [m] with nx x ny cells of two triangles each. pattern: "
        "alternating | diagonal.");
  m.def("grid", &grid, py::arg("width"), py::arg("height"), py::arg("triangles"), py::kw_only(),
        py::arg("pattern") = "alternating",
        "Rectangle of width x height [m] with about `triangles` triangles in nearly square cells.");
  m.def("jittered_grid", &jittered_grid, py::arg("width"), py::arg("height"), py::arg("nx"),
        py::arg("ny"), py::kw_only(), py::arg("amount"), py::arg("seed") = 1,
        "Grid whose interior vertices are displaced at random, along each axis by up to the "
        "fraction `amount` of a cell.");
  m.def("icosphere", &icosphere, py::arg("radius"), py::kw_only(), py::arg("subdivisions"),
        "Sphere with the given radius [m], approximated by a subdivided icosahedron.");
  m.def("box", &box, py::arg("x"), py::arg("y"), py::arg("z"), py::kw_only(),
        py::arg("cells_per_side") = 1, "Box with edge lengths x, y and z [m].");
  m.def("capsule", &capsule, py::arg("radius"), py::arg("length"), py::kw_only(),
        py::arg("segments") = 32,
        "Capsule along z with `length` between the centres of its caps [m].");
  m.def("cylinder", &cylinder, py::arg("radius"), py::arg("length"), py::kw_only(),
        py::arg("segments") = 32,
        "Cylinder along z [m], approximated by a prism with `segments` sides.");
  m.def("funnel", &funnel, py::arg("top_radius"), py::arg("bottom_radius"), py::arg("height"),
        py::arg("tube_length"), py::arg("wall"), py::kw_only(), py::arg("segments") = 64,
        "Closed surface of a funnel whose walls have a thickness `wall`; lengths in [m]. A cone "
        "from top_radius at z = height\n"
        "to bottom_radius at z = 0 continues as a tube below.");
  m.def("wave_bar", &wave_bar, py::arg("length"), py::arg("radius"), py::arg("amplitude"),
        py::arg("wavelength"), py::kw_only(), py::arg("segments") = 24,
        "Tube along y whose centre line is a sine wave in z; lengths in [m].");
  m.def("floor_square", &floor_square, py::arg("size"), py::kw_only(), py::arg("cells") = 8,
        "Open square in z = 0 with normal +z and edges `size` [m].");
}

void bind_queries(py::module_& m) {
  py::class_<ClosestPoint> point(m, "ClosestPoint", "Closest point on a surface.");
  point.def_readonly(
      "triangle", &ClosestPoint::triangle,
      "index of the triangle that contains the point; -1: no point within the radius");
  point.def_readonly("point", &ClosestPoint::point, "position (3) [m]");
  point.def_readonly("barycentric", &ClosestPoint::barycentric,
                     "barycentric coordinates (3) in the triangle [1]");
  point.def_readonly("normal", &ClosestPoint::normal,
                     "pseudo-normal of the closest feature, unit length");
  point.def_readonly("distance", &ClosestPoint::distance, "distance from the query point [m]");
  point.def("__repr__", [](const ClosestPoint& self) {
    return formatted("ClosestPoint(triangle={}, distance={})", self.triangle,
                     py::str(py::cast(self.distance)).cast<std::string>());
  });
  py::class_<SpatialQuery> c(m, "SpatialQuery",
                             "Closest-point queries and inside tests for a triangle surface.");
  c.def(py::init([](const TriangleMesh& mesh) {
          return SpatialQuery(mesh.vertices(), mesh.triangles());
        }),
        py::arg("mesh"));
  c.def(
      "closest",
      [](const SpatialQuery& self, const py::object& point, In<"m"> radius) {
        return self.closest(as_vector<Vec3>(point, {"point", "m"}), radius);
      },
      py::arg("point"), py::arg("radius"),
      "Returns the ClosestPoint to a point (3) [m] within a radius [m].");
  c.def(
      "inside",
      [](const SpatialQuery& self, const py::object& point) {
        return self.inside(as_vector<Vec3>(point, {"point", "m"}));
      },
      py::arg("point"), "True if the point (3) [m] lies inside a closed surface.");
}

// Returns the rows of an array of bytes (n x 3), or no rows for None. Throws InvalidInput for an
// array of another shape.
std::vector<std::array<std::uint8_t, 3>> colors_of_rows(
    const std::optional<py::array_t<std::uint8_t, py::array::c_style>>& rows) {
  if (!rows) return {};
  require(rows->ndim() == 2 && rows->shape(1) == 3,
          "colors must be bytes (uint8) of shape (n, 3), got {} dimensions", rows->ndim());
  std::vector<std::array<std::uint8_t, 3>> colors(static_cast<std::size_t>(rows->shape(0)));
  for (std::size_t i = 0; i < colors.size(); ++i)
    std::copy_n(rows->data(static_cast<py::ssize_t>(i), 0), 3, colors[i].begin());
  return colors;
}

}  // namespace

void bind_mesh(py::module_& m) {
  bind_triangle_mesh(m);
  bind_generators(m);
  bind_queries(m);
  m.def("split_polygons", &split_polygons, py::arg("corners"), py::arg("start"),
        "Returns the triangles of polygons as rows of corners (c x 3); polygon p has the corners "
        "start[p] to start[p + 1] - 1. Raises InvalidInput if an outline crosses itself.");
  m.def("read_mesh", &read_mesh, py::arg("path"), py::kw_only(), py::arg("with_uv") = true,
        "Reads a TriangleMesh from an OBJ or PLY file. with_uv=False omits rest coordinates.");
  m.def(
      "write_mesh",
      [](const std::string& path, const TriangleMesh& mesh, bool text, std::string library,
         std::vector<std::pair<Index, std::string>> materials,
         const std::optional<py::array_t<std::uint8_t, py::array::c_style>>& colors) {
        write_mesh(path, mesh, text,
                   {std::move(library), std::move(materials), colors_of_rows(colors)});
      },
      py::arg("path"), py::arg("mesh"), py::kw_only(), py::arg("text") = false,
      py::arg("library") = "", py::arg("materials") = py::list(), py::arg("colors") = py::none(),
      "Writes an OBJ or PLY file, depending on the extension of the path. text: writes PLY as text "
      "instead of binary. library: name of the .mtl file of an OBJ file. materials: (first "
      "triangle, name) of each material of an OBJ file, in ascending order of the triangles. "
      "colors: (n x 3) bytes in sRGB, colours of the vertices of a PLY file.");
}

}  // namespace loomstone
