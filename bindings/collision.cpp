// Candidate pairs, exact continuous tests, and the exact intersection count of a configuration.
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "bindings/bindings.h"
#include "core/collision/candidates.h"
#include "core/collision/collision_stage.h"
#include "core/collision/exact_continuous.h"

namespace loomstone {

namespace {

py::array_t<Index> as_array(const std::vector<std::array<Index, 2>>& pairs) {
  py::array_t<Index> array({static_cast<py::ssize_t>(pairs.size()), py::ssize_t{2}});
  std::copy_n(reinterpret_cast<const Index*>(pairs.data()), 2 * pairs.size(), array.mutable_data());
  return array;
}

void check_indices(const Triangles& triangles, Eigen::Index n) {
  if (triangles.size() > 0 && (triangles.minCoeff() < 0 || triangles.maxCoeff() >= n))
    throw InvalidInput("triangles must refer to points 0 to " + std::to_string(n - 1) + ", got " +
                       std::to_string(triangles.minCoeff()) + " to " + std::to_string(triangles.maxCoeff()));
}

}  // namespace

void bind_collision(py::module_& m) {
  m.def(
      "candidates",
      [](const py::object& x0, const py::object& x1, const py::object& triangles, double inflation, const std::string& engine,
         int threads) {
        const Points start = as_rows<Points>(x0, "x0"), end = as_rows<Points>(x1, "x1");
        const Triangles faces = as_rows<Triangles>(triangles, "triangles");
        if (threads < 0) throw InvalidInput("threads must be at least 0, got " + std::to_string(threads));
        Candidates found;
        {
          const py::gil_scoped_release release;
          found = candidates(Team{threads == 0 ? default_thread_count() : threads}, start, end, faces, inflation, engine);
        }
        return py::make_tuple(as_array(found.vertex_face), as_array(found.edge_edge));
      },
      py::arg("x0"), py::arg("x1"), py::arg("triangles"), py::arg("inflation") = 0.0, py::arg("engine") = "clusters",
      py::arg("threads") = 0,
      "Pairs of features of a surface that may collide while it moves from x0 to x1 on straight lines.\n\n"
      "x0, x1 (n, 3) [m], triangles (m, 3), inflation [m]: every box grows by it, so all pairs that come closer than twice\n"
      "as much are named. Returns vertex_face (k, 2) of vertex and triangle, and edge_edge (l, 2) of edges, which are rows of\n"
      "the sorted unique vertex pairs; both ascending, without pairs that share a vertex. engine: \"clusters\" (own tree),\n"
      "\"embree\", \"brute-force\": the same pairs, those whose 18-DOPs (2.56) overlap. threads 0: all processors.\n"
      "Raises InvalidInput for other shapes or engines, indices out of range, and coordinates that are not finite.");

  m.def(
      "intersecting_pairs",
      [](const py::object& points, const py::object& triangles) {
        const Points vertices = as_rows<Points>(points, "points");
        const Triangles faces = as_rows<Triangles>(triangles, "triangles");
        check_indices(faces, vertices.rows());
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
