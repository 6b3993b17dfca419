// Binds exceptions, step reports, the appearance of surfaces (Look), and frames.
#include "core/base/frame.h"

#include "bindings/bindings.h"
#include "bindings/descriptions.h"

namespace loomstone {

namespace {

// Sets the Python error indicator to an error of type `kind`. Bytes of the message that are not
// UTF-8, for example those quoted from a file, are escaped.
void raise(const py::handle& kind, const std::string& message) {
  const auto text = py::reinterpret_steal<py::object>(PyUnicode_DecodeUTF8(
      message.data(), static_cast<Py_ssize_t>(message.size()), "backslashreplace"));
  py::set_error(kind, text);
}

void bind_errors(py::module_& m) {
  static py::exception<Error> error(m, "Error", PyExc_Exception);
  error.attr("__doc__") = "Base class of all errors of this library.";
  const auto derived = [&](PyObject* standard) {
    return py::make_tuple(py::handle(error.ptr()), py::handle(standard));
  };
  const auto bases_input = derived(PyExc_ValueError);
  const auto bases_solver = derived(PyExc_RuntimeError);
  const auto bases_cache = derived(PyExc_OSError);
  const auto bases_unsupported = derived(PyExc_NotImplementedError);
  static py::exception<InvalidInput> input(m, "InvalidInput", bases_input);
  static py::exception<SolverFailure> solver(m, "SolverFailure", bases_solver);
  static py::exception<CacheError> cache(m, "CacheError", bases_cache);
  static py::exception<Unsupported> unsupported(m, "Unsupported", bases_unsupported);
  input.attr("__doc__") = "The input is invalid (a ValueError).";
  solver.attr("__doc__") =
      "A solve or a step failed (a RuntimeError). If a step of a simulation failed, the message "
      "names the step and the time at its start.";
  cache.attr("__doc__") = "A file could not be written, read or interpreted (an OSError).";
  unsupported.attr("__doc__") =
      "A feature that is not available in this build or in this combination (a "
      "NotImplementedError).";
  py::register_exception_translator([](std::exception_ptr failure) {
    try {
      if (failure) std::rethrow_exception(failure);
    } catch (const InvalidInput& e) {
      raise(input, e.what());
    } catch (const SolverFailure& e) {
      raise(solver, e.what());
    } catch (const CacheError& e) {
      raise(cache, e.what());
    } catch (const Unsupported& e) {
      raise(unsupported, e.what());
    } catch (const Error& e) {
      raise(error, e.what());
    }
  });
}

template <class Report>
void bind_report(py::module_& m, const char* name, const char* meaning) {
  py::class_<Report> c(m, name, meaning);
  c.def(py::init<>());
  for_each_field<Report>([&](const auto& each) {
    const std::string unit = *each.unit ? std::string(" [") + each.unit + "]" : std::string();
    c.def_readonly(each.name, each.member, (each.meaning + unit).c_str());
  });
  c.def(
      "to_dict", [](const Report& report) { return plain(report); },
      "Returns all numbers by name, with nested reports as dictionaries.");
  c.def("__repr__", [name](const Report& report) { return repr_description(report, name); });
}

// Returns all numbers of a report by path, such as "energy.kinetic". Tables of reports use these
// paths as column names.
py::dict numbers(const StepReport& report) {
  py::dict dict;
  for_each_number(report, [&](const std::string& path, const auto&, const auto& value) {
    dict[path.c_str()] = value;
  });
  return dict;
}

void bind_reports(py::module_& m) {
  bind_report<StageSeconds>(m, "StageSeconds", "Wall time of each stage of a step [s].");
  bind_report<ThreadReport>(m, "ThreadReport",
                            "Time that threads spend in the loops of collision handling [s].");
  bind_report<RankReport>(m, "RankReport",
                          "Times that ranks spend computing and waiting, bytes that they send, "
                          "and number of their collective operations.");
  bind_report<SolverReport>(m, "SolverReport", "Report on the solves of the integrator.");
  bind_report<ErrorReport>(m, "ErrorReport",
                           "Error of a step, and the parts into which the step is divided.");
  bind_report<ContactReport>(m, "ContactReport", "Report on contacts and intersections.");
  bind_report<WithheldReport>(m, "WithheldReport", "Report on motion withheld by certification.");
  bind_report<AccountReport>(
      m, "AccountReport",
      "Work and losses since the start, or since the user last wrote positions or velocities.");
  bind_report<StrainLimitReport>(m, "StrainLimitReport",
                                 "Report on the enforcement of strain limits.");
  bind_report<StrainReport>(m, "StrainReport",
                            "Strain U - I of all triangles at the end of the step [1].");
  bind_report<EnergyReport>(m, "EnergyReport", "Energies at the end of the step [J].");
  bind_report<MagnetReport>(m, "MagnetReport", "Report on the motion of magnets.");
  bind_report<CircuitReport>(m, "CircuitReport", "Report on electric circuits and bearings.");
  bind_report<StepReport>(m, "StepReport", "Record of a step. It never influences the simulation.");
  py::class_<StepReport> report = m.attr("StepReport");
  static_assert(std::is_trivially_copyable_v<StepReport>);
  report.def(py::pickle(
      [](const StepReport& self) {
        return py::bytes(reinterpret_cast<const char*>(&self), sizeof self);
      },
      [](const py::bytes& state) {
        const std::string bytes = state;
        if (bytes.size() != sizeof(StepReport))
          throw InvalidInput("a StepReport of another version cannot be unpickled");
        StepReport made;
        std::copy_n(bytes.data(), bytes.size(), reinterpret_cast<char*>(&made));
        return made;
      }));
  report.def("numbers", &numbers, "Returns all numbers by their path, such as \"energy.kinetic\".");
}

void bind_pickling(py::class_<FrameTopology>& c) {
  using T = FrameTopology;
  c.def(py::pickle(
      [](const T& self) {
        return py::make_tuple(self.triangles, self.corner_uv, self.cloth_of_triangle,
                              self.cloth_of_vertex, self.cloth_names, self.body_triangles,
                              self.body_of_triangle, self.body_of_vertex, self.body_names,
                              self.body_is_floor, self.body_pole, self.cloth_looks, self.body_looks,
                              self.body_corner_uv);
      },
      [](const py::tuple& state) {
        T made;
        std::size_t i = 0;
        const auto take = [&](auto& member) {
          member = state[i++].cast<std::decay_t<decltype(member)>>();
        };
        take(made.triangles), take(made.corner_uv), take(made.cloth_of_triangle);
        take(made.cloth_of_vertex), take(made.cloth_names), take(made.body_triangles);
        take(made.body_of_triangle), take(made.body_of_vertex), take(made.body_names);
        take(made.body_is_floor), take(made.body_pole), take(made.cloth_looks);
        take(made.body_looks), take(made.body_corner_uv);
        return made;
      }));
}

void bind_frame_topology(py::module_& m) {
  using T = FrameTopology;
  py::class_<T> c(m, "FrameTopology",
                  "Data of the frames that stay constant over a run. Cloths are concatenated, and "
                  "so are rigid bodies and obstacles.");
  const auto array = [&](const char* name, auto member, const char* text) {
    c.def_property_readonly(
        name, [member](const T& self) -> const auto& { return self.*member; },
        py::return_value_policy::reference_internal, text);
  };
  const auto list = [&](const char* name, auto member, const char* text) {
    c.def_property_readonly(
        name, [member](py::object self) { return view(self.cast<const T&>().*member, self); },
        text);
  };
  array("triangles", &T::triangles, "(m x 3) vertex indices of the cloth triangles");
  array("corner_uv", &T::corner_uv, "(3m x 2) rest coordinates of each triangle corner [m]");
  list("cloth_of_triangle", &T::cloth_of_triangle, "(m) index into cloth_names");
  list("cloth_of_vertex", &T::cloth_of_vertex, "(n) index into cloth_names");
  c.def_readonly("cloth_names", &T::cloth_names, "names of the cloths in the order of the scene");
  array("body_triangles", &T::body_triangles,
        "(mb x 3) vertex indices of the triangles of rigid bodies and obstacles");
  list("body_of_triangle", &T::body_of_triangle, "(mb) index into body_names");
  list("body_of_vertex", &T::body_of_vertex, "(nb) index into body_names");
  c.def_readonly("body_names", &T::body_names,
                 "names of the rigid bodies, followed by those of the obstacles");
  list("body_pole", &T::body_pole,
       "(nb) position between the poles of the nearest magnet: about 1 at the north pole, about -1 "
       "at the south pole, 0 away from magnets; may be empty");
  list("body_is_floor", &T::body_is_floor, "(bodies) 1 if the body is drawn as ground");
  c.def_readonly("cloth_looks", &T::cloth_looks,
                 "Look of each cloth; empty if no cloth has a look");
  c.def_readonly("body_looks", &T::body_looks,
                 "Look of each body and obstacle; empty if none of them has a look");
  array("body_corner_uv", &T::body_corner_uv,
        "(3mb x 2) uv of the corners of body_triangles [m]; no rows if no body has a texture");
  bind_pickling(c);
  c.def("__repr__", [](const T& self) {
    return formatted("FrameTopology({} cloth vertices, {} cloth triangles, {} body triangles)",
                     self.cloth_of_vertex.size(), self.triangles.rows(),
                     self.body_triangles.rows());
  });
}

void bind_frame(py::module_& m) {
  py::class_<Frame> c(
      m, "Frame",
      "State of a run at one instant, in the user's vertex order. Arrays are read-only views.");
  const auto array = [&](const char* name, auto member, const char* text) {
    c.def_property_readonly(
        name, [member](const Frame& self) -> const auto& { return self.*member; },
        py::return_value_policy::reference_internal, text);
  };
  c.def_readonly("time", &Frame::time, "time of the frame [s]");
  c.def_readonly("step", &Frame::step, "number of the last step");
  array("positions", &Frame::positions, "(n x 3) positions of the cloth vertices [m]");
  array("velocities", &Frame::velocities, "(n x 3) velocities of the cloth vertices [m/s]");
  array("strain", &Frame::strain, "(m x 3) Green strain: weft, warp and shear (E12) [1]");
  array("stretch", &Frame::stretch, "(m) largest principal stretch [1]");
  c.def_property_readonly(
      "contact", [](py::object self) { return view(self.cast<const Frame&>().contact, self); },
      "(n) 1 if the vertex took part in a contact, 2 if it was forced to intersect");
  array("body_vertices", &Frame::body_vertices,
        "(nb x 3) vertices of rigid bodies and obstacles [m]");
  array("coil_currents", &Frame::coil_currents,
        "(coils) currents in all coils, given or from circuits [A]");
  c.def_readonly("report", &Frame::report, "StepReport of the last step");
  c.def(
      "with_contact",
      [](Frame self, std::vector<std::uint8_t> contact) {
        self.contact = std::move(contact);
        return self;
      },
      py::arg("contact"),
      "Returns a copy with the given contact flags, which mark vertices in a picture.");
  c.def(py::pickle(
      [](const Frame& self) {
        return py::make_tuple(self.time, self.step, self.positions, self.velocities, self.strain,
                              self.stretch, self.contact, self.body_vertices, self.coil_currents,
                              self.report);
      },
      [](const py::tuple& state) {
        Frame made;
        std::size_t i = 0;
        const auto take = [&](auto& member) {
          member = state[i++].cast<std::decay_t<decltype(member)>>();
        };
        take(made.time), take(made.step), take(made.positions), take(made.velocities);
        take(made.strain), take(made.stretch), take(made.contact), take(made.body_vertices);
        take(made.coil_currents), take(made.report);
        return made;
      }));
  c.def("__repr__", [](const Frame& self) {
    return formatted("Frame(time={}, step={}, {} vertices)",
                     py::str(py::cast(self.time)).cast<std::string>(), self.step,
                     self.positions.rows());
  });
}

}  // namespace

void bind_base(py::module_& m) {
  bind_errors(m);
  bind_reports(m);
  bind_description<Look>(m, "Look",
                         "Colour, roughness and texture of a surface in pictures and exports. It "
                         "does not affect the simulation.");
  bind_frame_topology(m);
  bind_frame(m);
}

}  // namespace loomstone
