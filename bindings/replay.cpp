// Binds recorded motions of surfaces, and the replay of their collision searches on any number of
// ranks.
#include <memory>
#include <string>

#include "bindings/bindings.h"
#include "core/base/message.h"
#include "core/collision/collision_replay.h"
#include "core/parallel/communicator.h"
#include "core/parallel/team.h"

namespace loomstone {

namespace {

using SurfaceTable = Eigen::Matrix<Index, Eigen::Dynamic, 6, Eigen::RowMajor>;

// Returns the surfaces that a table lists, one per row. The columns of the table are kind
// (0: cloth, 1: body, 2: obstacle), first vertex, number of vertices, first triangle,
// number of triangles, and self-collision (0 or 1). `thickness` has one entry for each row [m].
std::vector<CollisionSurface> surfaces_of(const SurfaceTable& table, const Vector& thickness) {
  if (thickness.size() != table.rows())
    fail<InvalidInput>("thickness must have one entry for each of the {} surfaces, got {}",
                       table.rows(), thickness.size());
  std::vector<CollisionSurface> surfaces(table.rows());
  for (Index s = 0; s < table.rows(); ++s) {
    if (table(s, 0) < 0 || table(s, 0) > 2)
      fail<InvalidInput>("the kind of a surface must be 0, 1 or 2, got {}", table(s, 0));
    CollisionSurface& surface = surfaces[s];
    surface.kind = static_cast<CollisionSurface::Kind>(table(s, 0));
    surface.first_vertex = table(s, 1), surface.n_vertices = table(s, 2);
    surface.first_triangle = table(s, 3), surface.n_triangles = table(s, 4);
    surface.self_collision = table(s, 5) != 0;
    surface.thickness = thickness[s];
  }
  return surfaces;
}

SurfaceTable table_of(const std::vector<CollisionSurface>& surfaces) {
  SurfaceTable table(surfaces.size(), 6);
  for (std::size_t s = 0; s < surfaces.size(); ++s)
    table.row(s) << static_cast<Index>(surfaces[s].kind), surfaces[s].first_vertex,
        surfaces[s].n_vertices, surfaces[s].first_triangle, surfaces[s].n_triangles,
        surfaces[s].self_collision;
  return table;
}

Vector thickness_of(const std::vector<CollisionSurface>& surfaces) {
  Vector thickness(surfaces.size());
  for (std::size_t s = 0; s < surfaces.size(); ++s) thickness[s] = surfaces[s].thickness;
  return thickness;
}

void bind_record(py::module_& m) {
  py::class_<CollisionRecord> c(
      m, "CollisionRecord",
      "Motion of all surfaces in a step, as certification receives it.\n\n"
      "surfaces (s, 6): kind (0: cloth, 1: body, 2: obstacle), first vertex, number of vertices, "
      "first triangle, number of\n"
      "triangles, self-collision (0 or 1). thickness (s) [m]. triangles (t, 3). gap_floor [m]. x0, "
      "x1 (n, 3) [m]. earlier: positions\n"
      "(n, 3) at the starts of the preceding motions, the oldest first [m].");
  c.def(py::init([](const SurfaceTable& surfaces, const Vector& thickness,
                    const Triangles& triangles, double gap_floor, const Points& x0,
                    const Points& x1, const std::vector<Points>& earlier) {
          return CollisionRecord{
              surfaces_of(surfaces, thickness), triangles, gap_floor, x0, x1, earlier};
        }),
        py::kw_only(), py::arg("surfaces"), py::arg("thickness"), py::arg("triangles"),
        py::arg("gap_floor"), py::arg("x0"), py::arg("x1"),
        py::arg("earlier") = std::vector<Points>());
  c.def_property_readonly("surfaces",
                          [](const CollisionRecord& self) { return table_of(self.surfaces); });
  c.def_property_readonly("thickness",
                          [](const CollisionRecord& self) { return thickness_of(self.surfaces); });
  c.def_readonly("triangles", &CollisionRecord::triangles);
  c.def_readonly("gap_floor", &CollisionRecord::gap_floor);
  c.def_readonly("x0", &CollisionRecord::x0);
  c.def_readonly("x1", &CollisionRecord::x1);
  c.def_readonly("earlier", &CollisionRecord::earlier);
}

void bind_tests(py::module_& m) {
  py::class_<ReplayReport> r(m, "ReplayReport", "Predicted times of one search on several ranks.");
  r.def_readonly("seconds", &ReplayReport::seconds, "time until all ranks have all results [s]");
  r.def_readonly("exchange", &ReplayReport::exchange,
                 "part of `seconds` in which ranks exchange results [s]");
  r.def_readonly("least_busy", &ReplayReport::least_busy, "shortest work of a rank [s]");
  r.def_readonly("mean_busy", &ReplayReport::mean_busy, "mean work of the ranks [s]");
  r.def_readonly("most_busy", &ReplayReport::most_busy, "longest work of a rank [s]");
  r.def_readonly("requests", &ReplayReport::requests,
                 "number of requests for tasks, over all ranks");
  r.def_readonly("transfers", &ReplayReport::transfers,
                 "number of tasks that moved to another rank");
  r.def_readonly("refusals", &ReplayReport::refusals, "number of requests that were refused");

  py::class_<RecordedTests> c(m, "RecordedTests",
                              "Tests of one search that is divided among ranks, with their costs.");
  c.def_property_readonly("work", &RecordedTests::work, "sum of the costs of all tests [s]");
  c.def("__len__", &RecordedTests::size);
  c.def(
      "replay",
      [](const RecordedTests& self, const std::string& decomposition, In<"s"> latency,
         double bandwidth, In<"s"> overhead, In<"s"> poll_interval) {
        const Network network{latency, bandwidth, overhead};
        const auto how = choice_named<Decomposition>(decomposition, "decomposition");
        if (how == Decomposition::Predicted)
          fail<Unsupported>(
              "the decomposition of recorded tests must be static or dynamic, got predicted; "
              "CollisionReplay.lists() measures the lists of predicted searches");
        const py::gil_scoped_release release;
        return how == Decomposition::Static
                   ? replay_static(self, network)
                   : replay_dynamic(self, network, {.poll_interval = poll_interval});
      },
      py::arg("decomposition"), py::kw_only(), py::arg("latency") = 1.5e-6,
      py::arg("bandwidth") = 1e10, py::arg("overhead") = 0.2e-6, py::arg("poll_interval") = 5e-6,
      "Returns the ReplayReport of the search. decomposition: \"static\" or \"dynamic\". Messages "
      "take `latency` [s] and\n"
      "have `bandwidth` [bytes/s]. Sending a message, receiving one and polling each take "
      "`overhead` [s]. A rank that\n"
      "has work polls every `poll_interval` [s].");
}

void bind_lists(py::module_& m) {
  py::class_<OrderedWork> c(
      m, "RecordedLists",
      "Work of one search on neighbour lists, which ranks divide by the costs "
      "of an earlier step.");
  c.def_property_readonly("work", &OrderedWork::work, "sum of all costs [s]");
  c.def("__len__", [](const OrderedWork& self) { return self.seconds.size(); });
  c.def(
      "replay",
      [](const OrderedWork& self, int ranks, In<"s"> latency, double bandwidth, In<"s"> overhead) {
        if (ranks < 1) fail<InvalidInput>("ranks must be at least 1, got {}", ranks);
        return replay_predicted(self, ranks, {latency, bandwidth, overhead});
      },
      py::arg("ranks"), py::kw_only(), py::arg("latency") = 1.5e-6, py::arg("bandwidth") = 1e10,
      py::arg("overhead") = 0.2e-6,
      "Returns the ReplayReport of the search. Messages take `latency` [s] and have `bandwidth` "
      "[bytes/s]. Sending a message\n"
      "and receiving one each take `overhead` [s].");
}

}  // namespace

void bind_replay(py::module_& m) {
  bind_record(m);
  bind_tests(m);
  bind_lists(m);
  py::class_<CollisionReplay> c(m, "CollisionReplay",
                                "Measures the collision searches of a recorded motion.");
  c.def(py::init<CollisionRecord>(), py::arg("record"), py::call_guard<py::gil_scoped_release>());
  const auto search = [&](const char* name, CollisionReplay::Search which, const char* text) {
    c.def(
        name,
        [which](const CollisionReplay& self, int ranks, int repetitions,
                const std::string& decomposition) {
          const auto how = choice_named<Decomposition>(decomposition, "decomposition");
          const py::gil_scoped_release release;
          return self.measure(which, ranks, how, repetitions);
        },
        py::arg("ranks"), py::arg("repetitions") = 3, py::kw_only(),
        py::arg("decomposition") = "static", text);
  };
  c.def(
      "perform",
      [](const CollisionReplay& self, bool impacts, const std::string& decomposition,
         const std::string& traversal, int threads, std::shared_ptr<Communicator> communicator,
         int repetitions) {
        const CollisionReplay::Execution execution{
            choice_named<Decomposition>(decomposition, "decomposition"),
            choice_named<Traversal>(traversal, "traversal"), team_of(threads),
            communicator ? communicator : single_communicator()};
        const py::gil_scoped_release release;
        return self.perform(
            impacts ? CollisionReplay::Search::Impacts : CollisionReplay::Search::Contacts,
            execution, repetitions);
      },
      py::kw_only(), py::arg("impacts"), py::arg("decomposition") = "dynamic",
      py::arg("traversal") = "loops", py::arg("threads") = 1, py::arg("communicator") = py::none(),
      py::arg("repetitions") = 1,
      "Performs the search for impacts or for contacts several times, together with the other "
      "ranks. Returns, for each\n"
      "repetition, the time until the last rank has all results [s]. traversal: \"tasks\" or "
      "\"loops\" over threads; only\n"
      "the decomposition \"static\" uses it.");
  c.def(
      "lists",
      [](const CollisionReplay& self, int repetitions) {
        const CollisionReplay::Lists lists = self.measure_lists(repetitions);
        return std::pair(lists.contacts, lists.impacts);
      },
      py::arg("repetitions") = 3, py::call_guard<py::gil_scoped_release>(),
      "Returns the RecordedLists of the search for contacts at x0 and of the search for impacts "
      "from x0 to x1.");
  search("contacts", CollisionReplay::Search::Contacts,
         "Returns the RecordedTests of the search for contacts at x0, divided among `ranks` ranks. "
         "decomposition: \"static\" or\n"
         "\"dynamic\", which determines the tests with which each rank starts.");
  search("impacts", CollisionReplay::Search::Impacts,
         "Returns the RecordedTests of the search for impacts from x0 to x1, divided among `ranks` "
         "ranks, as contacts() does.");
}

}  // namespace loomstone
