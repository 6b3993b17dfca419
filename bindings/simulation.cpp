// Binds Simulation, which advances a scene in time, and State, whose tables are numpy views.
#include "core/sim/simulation.h"

#include "bindings/bindings.h"
#include "bindings/integrators.h"
#include "core/base/message.h"
#include "core/cloth/limits/strain_limiter.h"
#include "core/collision/model/contact.h"
#include "core/sim/model/state.h"

namespace loomstone {

namespace {

py::array_t<std::uint8_t> flags(std::vector<std::uint8_t>& values, py::handle owner) {
  return py::array_t<std::uint8_t>({static_cast<py::ssize_t>(values.size())}, {py::ssize_t{1}},
                                   values.data(), owner);
}

void bind_tables(py::class_<State>& c);
void bind_results(py::class_<State>& c);

void bind_state(py::module_& m) {
  py::class_<State> c(
      m, "State",
      "State tables as numpy views, without copies.\n\n"
      "Rows of the cloth's tables are permuted: row sim.vertex_order[i] belongs to vertex i "
      "of the scene. sim.positions and\n"
      "similar properties of Simulation use the order of the scene.\n\n"
      "A view keeps its simulation alive and shows the current state after every step and "
      "restore. Between steps, tables may\n"
      "be written in place or assigned, but not from another thread while a step runs. Every "
      "step first checks that written\n"
      "values are finite (InvalidInput). Writing positions or velocities discards the "
      "history of multistep schemes.\n\n"
      "Every rank stores all rows. Values that a rank writes take effect in the rows it owns "
      "(sim.owned_rows). Pin flags,\n"
      "the tables of obstacles, external_body_forces and external_body_torques take effect only if "
      "rank 0 writes them.");
  bind_tables(c);
  bind_results(c);
  c.def("__repr__", [](const State& s) {
    return formatted("State(step {}, {} cloth rows, {} bodies, {} obstacles)", s.step,
                     s.cloth.x.rows(), s.rigid.positions.rows(), s.pose_override.size());
  });
}

// Binds the tables of State that users may write.
void bind_tables(py::class_<State>& c) {
  const auto table = [&](const Argument& argument, auto get, const char* text) {
    c.def_property(
        argument.name, get,
        [get, argument](State& self, const py::object& values) {
          using Table = std::decay_t<decltype(get(self))>;
          auto& rows = get(self);
          rows.topRows(rows.rows()) = as_rows<Table>(values, argument, rows.rows());
        },
        text);
  };
  const auto flag = [&](const char* name, auto member, const char* text) {
    c.def_property_readonly(
        name, [member](py::object self) { return flags(self.cast<State&>().*member, self); }, text);
  };
  table(
      {"positions", "m"}, [](State& s) -> Points& { return s.cloth.x; },
      "(n x 3) positions [m]; written by the integrator, then by certification");
  table(
      {"velocities", "m/s"}, [](State& s) -> Points& { return s.cloth.v; },
      "(n x 3) velocities [m/s]; written by the integrator, then by certification");
  table(
      {"external_forces", "N"}, [](State& s) -> Points& { return s.made(s.external_force); },
      "(n x 3) external forces [N]; applied in every step until changed");
  table(
      {"external_body_forces", "N"}, [](State& s) -> Points& { return s.body_force; },
      "(b x 3) external forces on the rigid bodies [N]; applied in every step until changed");
  table(
      {"external_body_torques", "N m"}, [](State& s) -> Points& { return s.body_torque; },
      "(b x 3) external torques on the rigid bodies [N m]; applied in every step until changed");
  table(
      {"pin_targets", "m"}, [](State& s) -> Points& { return s.made(s.pin_target); },
      "(n x 3) positions of flagged pins at the end of the next step [m]");
  flag("pin_flags", &State::pin_override, "(n) 1: pin_targets replaces the script of this pin");
  table(
      {"obstacle_positions", "m"}, [](State& s) -> Points& { return s.pose_position; },
      "(o x 3) positions of flagged obstacles at the end of the next step [m]");
  table(
      "obstacle_orientations", [](State& s) -> auto& { return s.pose_orientation; },
      "(o x 4) orientations of flagged obstacles at the end of the next step: unit quaternions (w, "
      "x, y, z)");
  flag("obstacle_flags", &State::pose_override,
       "(o) 1: obstacle_positions and obstacle_orientations replace the keyframes");
}

// Binds the tables of State that only the simulation writes.
void bind_results(py::class_<State>& c) {
  const auto result = [&](const char* name, auto get, const char* text) {
    c.def_property_readonly(name, get, text);
  };
  result(
      "obstacle_vertices", [](const State& s) -> const Points& { return s.obstacle_vertices; },
      "(k x 3) vertices of all obstacles, concatenated [m], read-only");
  result(
      "body_centres", [](const State& s) -> const Points& { return s.rigid.positions; },
      "(b x 3) centres of mass [m], read-only");
  result(
      "body_orientations", [](const State& s) -> const auto& { return s.rigid.orientations; },
      "(b x 4) orientations: unit quaternions (w, x, y, z), read-only");
  result(
      "body_velocities", [](const State& s) -> const Points& { return s.rigid.velocities; },
      "(b x 3) velocities of the centres of mass [m/s], read-only");
  result(
      "body_angular_velocities",
      [](const State& s) -> const Points& { return s.rigid.angular_velocities; },
      "(b x 3) angular velocities in world axes [rad/s], read-only");
}

using S = Simulation;
using Released = py::call_guard<py::gil_scoped_release>;

void bind_stepping(py::class_<S>& c) {
  c.def(py::init([](const Scene& scene, const IntegratorOptions& integrator, int threads,
                    std::shared_ptr<Communicator> communicator, const std::string& decomposition) {
          const py::gil_scoped_release release;
          return new S(scene, integrator, threads,
                       communicator ? communicator : single_communicator(),
                       choice_named<Decomposition>(decomposition, "decomposition"));
        }),
        py::arg("scene"), py::arg("integrator") = IntegratorOptions{}, py::kw_only(),
        py::arg("threads") = 0, py::arg("communicator") = py::none(),
        py::arg("decomposition") = "predicted");
  c.def("step", &S::step, Released(),
        "Advances by one step. If SolverFailure is raised, the state remains that of the last "
        "successful step.");
  c.def_property_readonly("time", &S::time, "simulated time [s]");
  c.def_property_readonly("step_index", &S::step_index, "number of completed steps");
  c.def_property_readonly("step_size", &S::step_size,
                          "length of a step, or largest length of automatic steps [s]");
  c.def("stable_step", &S::stable_step, Released(),
        "Returns the longest step at which symplectic Euler is stable for small motions about the "
        "present positions [s]; infinite without cloth.");
  c.def_property_readonly("report", &S::report, py::return_value_policy::copy,
                          "StepReport of the last step. Later steps do not change it.");
  c.def("keep_collision_motion", &S::keep_collision_motion, py::arg("keep"),
        "Sets whether this rank keeps the motion that certification receives in each step for "
        "collision_motion(), with the\n"
        "starts of up to 16 preceding motions. The kept positions take up to 432 bytes a vertex; "
        "keep=False releases them.");
  c.def("collision_motion", &S::collision_motion,
        "Returns the CollisionRecord of the last certification whose motion was kept. The record "
        "has no vertices if no motion was kept or nothing collides.");
  c.def("rebuild_stages", &S::rebuild_stages, Released(),
        "Discards the engines of all stages and builds them again. If may_checkpoint is True, this "
        "does not change any later result.");
  c.def_property_readonly(
      "may_checkpoint", &S::may_checkpoint,
      "Whether a checkpoint may be taken now; False between rebuilds of the rigid-body world.");
  c.def("checkpoint", &S::checkpoint, Released(),
        "Returns a Checkpoint with the exact state. All ranks must call this method.\n\n"
        "Raises InvalidInput where may_checkpoint is False.");
  c.def("restore", &S::restore, py::arg("checkpoint"), Released(),
        "Restores the state from a checkpoint of the same scene.");
  c.def_property_readonly("topology", &S::topology, py::return_value_policy::reference_internal,
                          "FrameTopology: the data that all frames have in common");
  c.def("frame", &S::frame, Released(), "Returns the Frame of the current state.");
  c.def(
      "frame_at", [](S& self, In<"s"> time) { return self.frame_at(time); }, py::arg("time"),
      Released(), "Returns the Frame at a time [s] within the last step, by interpolation.");
}

void bind_ranks(py::class_<S>& c) {
  c.def_property_readonly("threads", &S::threads, "largest number of threads");
  c.def_property_readonly("decomposition", &S::decomposition,
                          "How collision handling is divided among ranks and threads.");
  c.def_property_readonly("hierarchy_bytes", &S::hierarchy_bytes,
                          "Memory of the bounding-volume hierarchies that this rank stores "
                          "[bytes].");
  c.def_property_readonly(
      "memory_bytes",
      [](const S& self) {
        std::map<std::string, std::size_t> parts;
        for (const S::MemoryPart& part : self.memory()) parts[part.name] = part.bytes;
        return parts;
      },
      "Memory that this rank occupies, by the part of the simulation that owns it [bytes].");
  c.def_property_readonly(
      "rank", [](const S& self) { return self.communicator().rank(); },
      "index of this rank, from 0");
  c.def_property_readonly(
      "ranks", [](const S& self) { return self.communicator().size(); }, "number of ranks");
  c.def(
      "agree", [](const S& self, std::int64_t value) { return self.communicator().maximum(value); },
      py::arg("value"), Released(), "Largest value over all ranks.");
  c.def_property_readonly(
      "owned_rows",
      [](const S& self) { return std::pair(self.owned_rows()[0], self.owned_rows()[1]); },
      "Range (first, end) of internal cloth rows that this rank computes.");
  c.def("gather", &S::gather, Released(),
        "Sends the values that each rank has written into its own rows to all ranks now rather "
        "than in the next step.\n"
        "All ranks must call this method.\n"
        "\n"
        "It is needed only after writing values. After every step, all ranks have all rows.");
  c.def_property_readonly("loop_iterations", &S::loop_iterations,
                          "Number of loop iterations that this rank has run within steps. It shows "
                          "how the work is divided.");
}

void bind_positions(py::class_<S>& c) {
  c.def_property_readonly(
      "vertex_order",
      [](py::object self) { return view(self.cast<const S&>().vertex_order(), self); },
      "(n) internal row of each vertex");
  c.def_property_readonly("state", &S::state,
                          "State with views of the internal tables, for reading and writing "
                          "between steps. Row vertex_order[i] belongs to vertex i.");
  const auto array = [&](const Argument& argument, auto get, auto set, const char* text) {
    c.def_property(
        argument.name, get,
        [get, set, argument](S& self, const py::object& values) {
          (self.*set)(as_rows<Points>(values, argument, (self.*get)().rows()));
        },
        text);
  };
  array({"positions", "m"}, &S::positions, &S::set_positions,
        "(n x 3) positions of the cloth vertices [m], a copy; assignable");
  array({"velocities", "m/s"}, &S::velocities, &S::set_velocities,
        "(n x 3) velocities of the cloth vertices [m/s], a copy; assignable");
  array({"external_forces", "N"}, &S::external_forces, &S::set_external_forces,
        "(n x 3) external forces on the cloth vertices [N], a copy; assignable; applied in every "
        "step until changed");
  array({"external_body_forces", "N"}, &S::external_body_forces, &S::set_external_body_forces,
        "(b x 3) external forces on the rigid bodies at their centres of mass [N], a copy; "
        "assignable; applied in every step until changed");
  array({"external_body_torques", "N m"}, &S::external_body_torques, &S::set_external_body_torques,
        "(b x 3) external torques on the rigid bodies about their centres of mass [N m], a copy; "
        "assignable; applied in every step until changed");
  c.def(
      "set_pin_targets",
      [](S& self, const py::object& targets) {
        self.set_pin_targets(as_rows<Points>(targets, {"targets", "m"}, self.positions().rows()));
      },
      py::arg("targets"),
      "Sets the positions that pinned vertices reach after the time step_size, (n x 3) [m]. Other "
      "rows are ignored.\n"
      "The targets replace the script.");
  c.def(
      "set_obstacle_pose",
      [](S& self, int obstacle, const py::object& position, const py::object& orientation) {
        self.set_obstacle_pose(obstacle, as_vector<Vec3>(position, {"position", "m"}),
                               as_vector<Vec4>(orientation, "orientation"));
      },
      py::arg("obstacle").noconvert(), py::arg("position"),
      py::arg("orientation") = py::make_tuple(1, 0, 0, 0),
      "Sets the pose that an obstacle reaches after the time step_size: position [m] and "
      "quaternion (w, x, y, z).\n"
      "The pose replaces the keyframes.");
  c.def_property_readonly("body_centres", &S::body_centres, "(b x 3) centres of mass [m], a copy");
}

void bind_circuits(py::class_<S>& c) {
  c.def("magnetic_forces", &S::magnetic_forces, Released(),
        "Returns forces [N] and torques about the centres [N m] that magnets and currents now "
        "exert on bodies, each (b x 3).");
  const auto electric = [&](const char* name, double CircuitState::* member, const char* text) {
    c.def_property_readonly(
        name, [member](const S& self) { return self.circuits().*member; }, text);
  };
  c.def_property_readonly("current", &S::current, "present current of the first circuit [A]");
  c.def_property_readonly("currents", &S::currents,
                          "(coils) present currents of all coils, given or from circuits [A]");
  electric("circuit_heat", &CircuitState::heat,
           "heat released in the resistances of the circuits since the start [J]");
  electric("circuit_supply", &CircuitState::supply,
           "energy supplied by the sources of all coils since the start [J]");
  electric("bearing_work", &CircuitState::bearings,
           "energy removed by friction and torques of bearings since the start [J]");
  c.def("magnets", &S::magnets, py::arg("frame"), Released(),
        "Returns the magnets at their poses in a frame of this scene, in the order of the scene, "
        "followed by the coils that\n"
        "carry a current. Magnetisable spheres have the magnetisation of that frame.");
}

void bind_failures(py::class_<S>& c) {
  c.def_property_readonly(
      "forced_pairs", &S::forced_pairs,
      "Pairs of triangles that intersect at the end of the last step, for example because scripted "
      "motion left the cloth no room.\n"
      "They are listed from a step that leaves impacts unresolved until no pair intersects. "
      "Triangles of all surfaces are numbered\n"
      "consecutively.");
  c.def_property_readonly(
      "broken_limits", [](const S& self) { return named(self.broken_limits()); },
      "(triangle, \"weft\" | \"warp\" | \"shear\", excess) for each strain limit that the "
      "last step left exceeded by more than\n"
      "0.01 or, if the limit is below 0.05, by more than a fifth of the limit and more than 1e-4. "
      "The largest excess comes first.\n"
      "Triangles of all cloths are numbered consecutively.");
  c.def(
      "intersecting_pairs", &S::intersecting_pairs, Released(),
      "Returns the pairs of triangles that intersect in the current state and share no vertex.\n\n"
      "The triangles of all surfaces are numbered consecutively: cloths, rigid bodies, "
      "obstacles. Pairs without cloth are included: a body that rests on an obstacle or on "
      "another body can overlap it slightly.");
  c.def(
      "near_contacts",
      [](const S& self) {
        std::vector<Contact> contacts;
        {
          const py::gil_scoped_release release;
          contacts = self.near_contacts();
        }
        const auto n = static_cast<py::ssize_t>(contacts.size());
        py::array_t<Index> vertices({n, py::ssize_t{4}});
        py::array_t<double> distances(n), thicknesses(n);
        for (py::ssize_t i = 0; i < n; ++i) {
          std::copy_n(contacts[i].vertices.data(), 4, vertices.mutable_data(i, 0));
          distances.mutable_at(i) = contacts[i].distance;
          thicknesses.mutable_at(i) = contacts[i].thickness;
        }
        return py::make_tuple(vertices, distances, thicknesses);
      },
      "Returns the pairs of features that are closer than their contact distance in the current "
      "state.\n"
      "\n"
      "The result is a tuple of the vertices of each pair (k x 4), their distances (k) [m] and "
      "their contact distances (k) [m].\n"
      "A pair is a vertex and the three corners of a triangle, or the ends of two edges. Vertices "
      "of all surfaces are numbered\n"
      "consecutively: cloth, then bodies, then obstacles. All ranks must call this method.");
}

}  // namespace

void bind_simulation(py::module_& m) {
  bind_state(m);
  py::class_<S> c(m, "Simulation",
                  "Model, State and Stepper of a scene. Arrays are in the user's vertex order.");
  bind_stepping(c);
  bind_ranks(c);
  bind_positions(c);
  bind_circuits(c);
  bind_failures(c);
}

}  // namespace loomstone
