// A built scene that advances.
#include "core/sim/simulation.h"

#include "bindings/bindings.h"

namespace loomstone {

void bind_simulation(py::module_& m) {
  using S = Simulation;
  const auto released = py::call_guard<py::gil_scoped_release>();
  py::class_<S> c(m, "Simulation", "Model, State and Stepper of a scene. Arrays are in the user's vertex order.");
  c.def(py::init([](const Scene& scene, const IntegratorOptions& integrator, int threads,
                    std::shared_ptr<Communicator> communicator) {
          const py::gil_scoped_release release;
          return new S(scene, integrator, threads, communicator ? communicator : single_communicator());
        }),
        py::arg("scene"), py::arg("integrator") = IntegratorOptions{}, py::kw_only(), py::arg("threads") = 0,
        py::arg("communicator") = py::none());
  c.def("step", &S::step, released, "Advances by one step; SolverFailure leaves the last good state.");
  c.def_property_readonly("time", &S::time, "[s]");
  c.def_property_readonly("step_index", &S::step_index, "steps done");
  c.def_property_readonly("step_size", &S::step_size, "[s]");
  c.def_property_readonly("threads", &S::threads);
  c.def_property_readonly("rank", [](const S& self) { return self.communicator().rank(); });
  c.def_property_readonly("ranks", [](const S& self) { return self.communicator().size(); });
  c.def_property_readonly("report", &S::report, "StepReport of the last step");
  c.def_property_readonly("may_checkpoint", &S::may_checkpoint, "False between rebuilds of the rigid-body world.");
  c.def("agree", [](const S& self, std::int64_t value) { return self.communicator().maximum(value); }, py::arg("value"),
        released, "Largest value over all ranks.");
  c.def_property_readonly("topology", &S::topology, py::return_value_policy::reference_internal);
  c.def("frame", &S::frame, released, "Frame of the present state.");
  c.def("frame_at", &S::frame_at, py::arg("time"), released, "Frame between the last two steps, interpolated.");
  c.def_property_readonly("vertex_order", [](py::object self) { return view(self.cast<const S&>().vertex_order(), self); },
                          "(n) internal row of each vertex");
  const auto array = [&](const char* name, auto get, auto set, const char* text) {
    c.def_property(name, get,
                   [get, set, name](S& self, const py::object& values) {
                     (self.*set)(as_rows<Points>(values, name, (self.*get)().rows()));
                   },
                   text);
  };
  array("positions", &S::positions, &S::set_positions, "(n x 3) [m], a copy; assignable");
  array("velocities", &S::velocities, &S::set_velocities, "(n x 3) [m/s], a copy; assignable");
  array("external_forces", &S::external_forces, &S::set_external_forces,
        "(n x 3) [N], a copy; assignable; added to every step until changed");
  c.def("set_pin_targets",
        [](S& self, const py::object& targets) {
          self.set_pin_targets(as_rows<Points>(targets, "targets", self.positions().rows()));
        },
        py::arg("targets"),
        "Where pinned vertices are at the end of the next step, (n x 3) [m]; other rows are ignored. Replaces the script.");
  c.def("set_obstacle_pose", &S::set_obstacle_pose, py::arg("obstacle"), py::arg("position"),
        py::arg("orientation") = Vec4(1, 0, 0, 0),
        "Pose of an obstacle at the end of the next step: position [m], quaternion (w, x, y, z). Replaces its keyframes.");
  c.def_property_readonly("body_positions", &S::body_positions, "(b x 3) centres of mass [m], a copy");
  c.def("checkpoint", &S::checkpoint, released, "The state, exactly.");
  c.def("restore", &S::restore, py::arg("checkpoint"), released, "Continues from a checkpoint of the same scene.");
  c.def("rebuild_stages", &S::rebuild_stages, released, "Throws all stages away; changes no bit of the future.");
  c.def("intersecting_pairs", &S::intersecting_pairs, released,
        "Pairs of triangles that intersect now, all surfaces end to end.");
}

}  // namespace loomstone
