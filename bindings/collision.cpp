// Exact intersection count of a configuration, and exact continuous tests.
#include <cmath>
#include <limits>
#include <string>

#include "bindings/bindings.h"
#include "core/collision/collision_stage.h"
#include "core/collision/exact_continuous.h"

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
  m.def(
      "continuous",
      [](const std::string& kind, const py::array_t<double, py::array::c_style | py::array::forcecast>& queries) {
        if (kind != "vertex-face" && kind != "edge-edge")
          throw InvalidInput("kind must be \"vertex-face\" or \"edge-edge\", got \"" + kind + "\"");
        if (queries.ndim() != 3 || queries.shape(1) != 8 || queries.shape(2) != 3)
          throw InvalidInput("queries must have shape (n, 8, 3), got " + py::str(queries.attr("shape")).cast<std::string>());
        const py::ssize_t n = queries.shape(0);
        for (py::ssize_t i = 0; i < queries.size(); ++i)
          if (!std::isfinite(queries.data()[i]))
            throw InvalidInput("queries must be finite, but query " + std::to_string(i / 24) + " is not");
        py::array_t<bool> hit(n);
        py::array_t<double> time(n);
        bool* const hits = hit.mutable_data();
        double* const times = time.mutable_data();
        {
          const py::gil_scoped_release release;
          for (py::ssize_t i = 0; i < n; ++i) {
            MovingPoints q;
            for (int k = 0; k < 8; ++k) q[k] = Eigen::Map<const Vec3>(queries.data() + 24 * i + 3 * k);
            const Impact impact = kind == "edge-edge" ? exact_continuous_edge_edge(q) : exact_continuous_vertex_face(q);
            hits[i] = impact.hit;
            times[i] = impact.hit ? impact.time : std::numeric_limits<double>::infinity();
          }
        }
        return py::make_tuple(hit, time);
      },
      py::arg("kind"), py::arg("queries"),
      "Exact continuous collision tests of points that move on straight lines over a step, times in [0, 1].\n\n"
      "kind: \"vertex-face\" (vertex, three corners) or \"edge-edge\" (two ends, two ends). queries (n, 8, 3) [m]: the four\n"
      "points at the start, then the same at the end. Returns hit (n) bool, exact and with touching counted, and time (n),\n"
      "a lower bound of the first contact [1], infinity where there is none. Raises InvalidInput for another kind or shape,\n"
      "or numbers that are not finite.");
}

}  // namespace loomstone
