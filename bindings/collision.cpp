// Candidate pairs, exact continuous collision detection, and exact intersections of a
// configuration.
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <utility>

#include "bindings/bindings.h"
#include "core/base/message.h"
#include "core/collision/candidates.h"
#include "core/collision/detector.h"
#include "core/collision/narrow_phase/exact_continuous.h"
#include "core/collision/narrow_phase/separation.h"
#include "core/collision/tangle/intersections.h"
#include "core/parallel/team.h"

namespace loomstone {

namespace {

// Hands the pairs over without a copy.
py::array_t<Index> as_array(std::vector<std::array<Index, 2>>&& pairs) {
  auto* const kept = new std::vector<std::array<Index, 2>>(std::move(pairs));
  const py::capsule owner(
      kept, [](void* p) { delete static_cast<std::vector<std::array<Index, 2>>*>(p); });
  return py::array_t<Index>({static_cast<py::ssize_t>(kept->size()), py::ssize_t{2}},
                            reinterpret_cast<const Index*>(kept->data()), owner);
}

py::array_t<Index> view_of_pairs(const std::vector<std::array<Index, 2>>& pairs, py::handle owner) {
  py::array_t<Index> array({static_cast<py::ssize_t>(pairs.size()), py::ssize_t{2}},
                           reinterpret_cast<const Index*>(pairs.data()), owner);
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

py::array_t<Index> view_of_rows(const Edges& edges, py::handle owner) {
  py::array_t<Index> array({static_cast<py::ssize_t>(edges.rows()), py::ssize_t{2}}, edges.data(),
                           owner);
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

// A detector with its threads.
struct BoundDetector {
  Detector detector;
  Team team;
};

void check_indices(const Triangles& triangles, Eigen::Index n) {
  if (triangles.size() > 0 && (triangles.minCoeff() < 0 || triangles.maxCoeff() >= n))
    fail<InvalidInput>("triangles must refer to points 0 to {}, got {} to {}", n - 1,
                       triangles.minCoeff(), triangles.maxCoeff());
}

// Exact tests of n queries of eight points; times are infinity for queries without a hit.
void test_queries(bool vertex_face, py::ssize_t n, const double* queries, bool* hits,
                  double* times) {
  std::fill_n(hits, n, false);
  std::fill_n(times, n, std::numeric_limits<double>::infinity());
  const auto point = [&](Index i, int k) {
    return queries + 24 * static_cast<std::size_t>(i) + 3 * k;
  };
  without_separated(vertex_face, static_cast<Index>(n), point, [&](Index i) {
    MovingPoints q;
    for (int k = 0; k < 8; ++k) q[k] = Eigen::Map<const Vec3>(point(i, k));
    const ExactImpact impact =
        vertex_face ? exact_continuous_vertex_face(q) : exact_continuous_edge_edge(q);
    hits[i] = impact.hit;
    if (impact.hit) times[i] = impact.time;
  });
}

void bind_candidates(py::module_& m) {
  m.def(
      "candidates",
      [](const py::object& x0, const py::object& x1, const py::object& triangles, In<"m"> inflation,
         const std::string& engine, int threads) {
        const Points start = as_rows<Points>(x0, {"x0", "m"}),
                     end = as_rows<Points>(x1, {"x1", "m"});
        const Triangles faces = as_rows<Triangles>(triangles, "triangles");
        const Team team = team_of(threads);
        Candidates found;
        {
          const py::gil_scoped_release release;
          found = candidates(team, start, end, faces, inflation, engine);
        }
        return py::make_tuple(as_array(std::move(found.vertex_face)),
                              as_array(std::move(found.edge_edge)));
      },
      py::arg("x0"), py::arg("x1"), py::arg("triangles"), py::arg("inflation") = 0.0,
      py::arg("engine") = "clusters", py::arg("threads") = 0,
      "Pairs of features of a surface that may collide while it moves from x0 to x1 on straight "
      "lines.\n\n"
      "x0, x1 (n, 3) [m], triangles (m, 3), inflation [m]: every box grows by it, so all pairs "
      "that come closer than twice\n"
      "as much are named. Returns vertex_face (k, 2) of vertex and triangle, and edge_edge (l, 2) "
      "of edges, which are rows of\n"
      "the sorted unique vertex pairs; both ascending, without pairs that share a vertex. engine: "
      "\"clusters\" (own tree),\n"
      "\"embree\", \"brute-force\": the same pairs, those whose 18-DOPs (2.56) overlap. threads 0: "
      "all processors.\n"
      "Raises InvalidInput for other shapes or engines, indices out of range, and coordinates that "
      "are not finite.");
}

void bind_intersecting_pairs(py::module_& m) {
  m.def(
      "intersecting_pairs",
      [](const py::object& points, const py::object& triangles) {
        const Points vertices = as_rows<Points>(points, {"points", "m"});
        const Triangles faces = as_rows<Triangles>(triangles, "triangles");
        check_indices(faces, vertices.rows());
        const py::gil_scoped_release release;
        return intersecting_pairs(vertices, faces);
      },
      py::arg("points"), py::arg("triangles"),
      "Pairs of triangles that intersect and share no vertex, ascending. points (n x 3) [m], "
      "triangles (m x 3).");
}

void bind_continuous(py::module_& m) {
  m.def(
      "continuous",
      [](const std::string& kind,
         const py::array_t<double, py::array::c_style | py::array::forcecast>& queries) {
        if (kind != "vertex-face" && kind != "edge-edge")
          fail<InvalidInput>("kind must be \"vertex-face\" or \"edge-edge\", got \"{}\"", kind);
        if (queries.ndim() != 3 || queries.shape(1) != 8 || queries.shape(2) != 3)
          fail<InvalidInput>("queries must have shape (n, 8, 3), got {}",
                             py::str(queries.attr("shape")).cast<std::string>());
        const py::ssize_t n = queries.shape(0);
        for (py::ssize_t i = 0; i < queries.size(); ++i)
          if (!std::isfinite(queries.data()[i]))
            fail<InvalidInput>("queries must be finite, but query {} is not", i / 24);
        py::array_t<bool> hit(n);
        py::array_t<double> time(n);
        bool* const hits = hit.mutable_data();
        double* const times = time.mutable_data();
        {
          const py::gil_scoped_release release;
          test_queries(kind == "vertex-face", n, queries.data(), hits, times);
        }
        return py::make_tuple(hit, time);
      },
      py::arg("kind"), py::arg("queries"),
      "Exact continuous collision tests of points that move on straight lines over a step, times "
      "in [0, 1].\n\n"
      "kind: \"vertex-face\" (vertex, three corners) or \"edge-edge\" (two ends, two ends). "
      "queries (n, 8, 3) [m]: the four\n"
      "points at the start, then the same at the end. Returns hit (n) bool, exact and with "
      "touching counted, and time (n),\n"
      "a lower bound of the first contact [1], infinity where there is none. Raises InvalidInput "
      "for another kind or shape,\n"
      "or numbers that are not finite.");
}

void bind_collisions(py::module_& m) {
  py::class_<Collisions>(m, "Collisions",
                         "Colliding pairs of a motion, with times. Made by Detector.collisions().")
      .def_property_readonly(
          "vertex_face",
          [](const py::object& self) {
            return view_of_pairs(self.cast<const Collisions&>().pairs.vertex_face, self);
          },
          "Vertex and triangle (k, 2), ascending.")
      .def_property_readonly(
          "edge_edge",
          [](const py::object& self) {
            return view_of_pairs(self.cast<const Collisions&>().pairs.edge_edge, self);
          },
          "Edges (l, 2), rows of Detector.edges, smaller first, ascending.")
      .def_property_readonly(
          "vertex_face_time",
          [](const py::object& self) {
            return view(self.cast<const Collisions&>().vertex_face_time, self);
          },
          "Lower bounds of the first contacts (k) [1].")
      .def_property_readonly(
          "edge_edge_time",
          [](const py::object& self) {
            return view(self.cast<const Collisions&>().edge_edge_time, self);
          },
          "Lower bounds of the first contacts (l) [1].")
      .def_property_readonly(
          "time", &Collisions::time,
          "Lower bound of the first contact of all; infinity where there is none [1].")
      .def("__len__", [](const Collisions& c) {
        return c.pairs.vertex_face.size() + c.pairs.edge_edge.size();
      });
}

void bind_detector(py::module_& m) {
  py::class_<BoundDetector>(
      m, "Detector",
      "Collisions of one surface with itself, found again and again while it moves.\n\n"
      "A tree is formed at the first call and follows the positions from then on. A detector "
      "serves one\n"
      "Python thread at a time.")
      .def(py::init([](const py::object& triangles, int threads) {
             return std::make_unique<BoundDetector>(BoundDetector{
                 Detector(as_rows<Triangles>(triangles, "triangles")), team_of(threads)});
           }),
           py::arg("triangles"), py::kw_only(), py::arg("threads") = 0,
           "triangles (m, 3); threads 0: all processors. No result depends on their number.")
      .def(
          "candidates",
          [](BoundDetector& self, const py::object& x0, const py::object& x1, In<"m"> inflation,
             bool ordered) {
            const Points start = as_rows<Points>(x0, {"x0", "m"}),
                         end = as_rows<Points>(x1, {"x1", "m"});
            FeatureIds found;
            {
              const py::gil_scoped_release release;
              found = self.detector.candidates(self.team, start, end, inflation, ordered);
            }
            return py::make_tuple(as_array(std::move(found.vertex_face)),
                                  as_array(std::move(found.edge_edge)));
          },
          py::arg("x0"), py::arg("x1"), py::arg("inflation") = 0.0, py::kw_only(),
          py::arg("ordered") = true,
          "The pairs that collision.candidates() names. ordered: ascending; otherwise in an order "
          "that depends on the tree.")
      .def(
          "collisions",
          [](BoundDetector& self, const py::object& x0, const py::object& x1) {
            const Points start = as_rows<Points>(x0, {"x0", "m"}),
                         end = as_rows<Points>(x1, {"x1", "m"});
            const py::gil_scoped_release release;
            return self.detector.collisions(self.team, start, end);
          },
          py::arg("x0"), py::arg("x1"),
          "Every pair of features without a common vertex that touches while the points move from "
          "x0 to x1 on straight lines.\n\n"
          "x0, x1 (n, 3) [m]. Exact: none is missed and none is false, touching counts.")
      .def(
          "forget_trees", [](BoundDetector& self) { self.detector.forget_trees(); },
          "Forms the tree anew at the next call. It changes speed at most, no result.")
      .def_property_readonly(
          "edges",
          [](const py::object& self) {
            return view_of_rows(self.cast<const BoundDetector&>().detector.edges(), self);
          },
          "Sorted unique vertex pairs (k, 2).")
      .def_property_readonly(
          "tree_bytes", [](const BoundDetector& self) { return self.detector.tree_bytes(); },
          "Memory of the tree [byte].");
}

}  // namespace

void bind_collision(py::module_& m) {
  bind_candidates(m);
  bind_intersecting_pairs(m);
  bind_continuous(m);
  bind_collisions(m);
  bind_detector(m);
}

}  // namespace loomstone
