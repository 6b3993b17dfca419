// Exact intersection count of a configuration.
#include "bindings/bindings.h"
#include "core/collision/collision_stage.h"

namespace loomstone {

void bind_collision(py::module_& m) {
  m.def(
      "intersecting_pairs",
      [](const py::object& points, const py::object& triangles) {
        const Points vertices = as_rows<Points>(points, "points");
        const Triangles faces = as_rows<Triangles>(triangles, "triangles");
        const py::gil_scoped_release release;
        return intersecting_pairs(vertices, faces);
      },
      py::arg("points"), py::arg("triangles"),
      "Pairs of triangles that intersect and share no vertex, ascending. points (n x 3) [m], triangles (m x 3).");
}

}  // namespace loomstone
