// Binds the search for candidate pairs, exact continuous collision detection, exact intersection
// tests, and the Detector of self-collisions.
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

// Returns a numpy array that owns the pairs, without copying them.
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

// A detector and the team of threads that runs it.
struct BoundDetector {
  Detector detector;
  Team team;
};

void check_indices(const Triangles& triangles, Eigen::Index n) {
  if (triangles.size() > 0 && (triangles.minCoeff() < 0 || triangles.maxCoeff() >= n))
    fail<InvalidInput>("triangles must hold point indices in [0, {}), got {} to {}", n,
                       triangles.minCoeff(), triangles.maxCoeff());
}

// Sets hits[i] to the result of the exact continuous collision test on query i, and times[i] to a
// lower bound of the time of its first impact (0: start, 1: end), or to infinity without an impact.
// Each of the n queries has eight points: four points at the start, then the same points at the
// end. The four points are a vertex and the corners of a triangle if `vertex_face` is true, and the
// ends of two edges otherwise.
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
      "Pairs of features of a surface that may collide while it moves from x0 to x1 along straight "
      "lines.\n"
      "\n"
      "x0, x1 (n, 3) [m], triangles (m, 3). inflation [m]: every bounding box grows by this "
      "length, so the result contains\n"
      "all pairs that come closer than twice the inflation. Returns vertex_face (k, 2), a vertex "
      "and a triangle, and\n"
      "edge_edge (l, 2), two edges given as rows of the sorted unique vertex pairs. Both are in "
      "ascending order and exclude\n"
      "pairs that share a vertex. engine: \"clusters\" (loomstone's own tree), \"embree\" or "
      "\"brute-force\". All of them return the same\n"
      "pairs, which are those whose 18-DOPs overlap, (2.56) of [Thomaszewski2010]. threads 0: "
      "OMP_NUM_THREADS or all processors.\n"
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
        for (Index i = 0; i < vertices.rows(); ++i)
          if (!vertices.row(i).allFinite())
            fail<InvalidInput>("points must be finite, but row {} is not", i);
        const py::gil_scoped_release release;
        return intersecting_pairs(vertices, faces);
      },
      py::arg("points"), py::arg("triangles"),
      "Pairs of triangles that intersect and share no vertex, in ascending order. points (n x 3) "
      "[m], triangles (m x 3).");
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
      "Exact continuous collision tests for points that move along straight lines over a "
      "step, with time in [0, 1].\n\n"
      "kind: \"vertex-face\" (vertex, three corners) or \"edge-edge\" (two ends, two ends). "
      "queries (n, 8, 3) [m]: the four\n"
      "points at the start, then the same points at the end. Returns hit (n) and time (n). "
      "hit is exact, and touching counts\n"
      "as a hit. time is a lower bound of the first contact time [1], or infinity without a "
      "hit. Raises InvalidInput for\n"
      "another kind or shape, and for numbers that are not finite.");
}

void bind_collisions(py::module_& m) {
  py::class_<Collisions>(m, "Collisions",
                         "Pairs of features that collide during a motion, and their contact times. "
                         "Returned by Detector.collisions().")
      .def_property_readonly(
          "vertex_face",
          [](const py::object& self) {
            return view_of_pairs(self.cast<const Collisions&>().pairs.vertex_face, self);
          },
          "(k, 2) vertex and triangle of each pair, in ascending order.")
      .def_property_readonly(
          "edge_edge",
          [](const py::object& self) {
            return view_of_pairs(self.cast<const Collisions&>().pairs.edge_edge, self);
          },
          "(l, 2) the two edges of each pair as rows of Detector.edges, the smaller first. Pairs "
          "are in ascending order.")
      .def_property_readonly(
          "vertex_face_time",
          [](const py::object& self) {
            return view(self.cast<const Collisions&>().vertex_face_time, self);
          },
          "(k) lower bounds of the first contact times [1].")
      .def_property_readonly(
          "edge_edge_time",
          [](const py::object& self) {
            return view(self.cast<const Collisions&>().edge_edge_time, self);
          },
          "(l) lower bounds of the first contact times [1].")
      .def_property_readonly(
          "time", &Collisions::time,
          "Lower bound of the earliest contact time of all pairs [1]; infinity without collisions.")
      .def("__len__", [](const Collisions& c) {
        return c.pairs.vertex_face.size() + c.pairs.edge_edge.size();
      });
}

void bind_detector(py::module_& m) {
  py::class_<BoundDetector>(
      m, "Detector",
      "Self-collisions of one surface, for repeated queries while it moves.\n\n"
      "The first query builds a tree. Later queries refit the tree to the positions, or rebuild "
      "it if its boxes have grown\n"
      "too much. Only one Python thread at a time may use a detector.")
      .def(py::init([](const py::object& triangles, int threads) {
             return std::make_unique<BoundDetector>(BoundDetector{
                 Detector(as_rows<Triangles>(triangles, "triangles")), team_of(threads)});
           }),
           py::arg("triangles"), py::kw_only(), py::arg("threads") = 0,
           "triangles (m, 3); threads 0: OMP_NUM_THREADS or all processors. Results do not "
           "depend on the number of threads.")
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
          "Returns the same pairs as collision.candidates(). ordered: whether the pairs are sorted "
          "in ascending order; otherwise their order depends on the tree.")
      .def(
          "collisions",
          [](BoundDetector& self, const py::object& x0, const py::object& x1) {
            const Points start = as_rows<Points>(x0, {"x0", "m"}),
                         end = as_rows<Points>(x1, {"x1", "m"});
            const py::gil_scoped_release release;
            return self.detector.collisions(self.team, start, end);
          },
          py::arg("x0"), py::arg("x1"),
          "Finds all pairs of features without a common vertex that touch while the points move "
          "from x0 to x1 along straight\n"
          "lines.\n\n"
          "x0, x1 (n, 3) [m]. The result is exact: no pair is missed and none is false. Touching "
          "counts.")
      .def(
          "forget_trees", [](BoundDetector& self) { self.detector.forget_trees(); },
          "Makes the next query rebuild the tree. This can change only the order of candidates "
          "with ordered=False.")
      .def_property_readonly(
          "edges",
          [](const py::object& self) {
            return view_of_rows(self.cast<const BoundDetector&>().detector.edges(), self);
          },
          "(k, 2) sorted unique vertex pairs.")
      .def_property_readonly(
          "tree_bytes", [](const BoundDetector& self) { return self.detector.tree_bytes(); },
          "Memory used by the tree [byte].");
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
