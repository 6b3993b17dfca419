// Errors, reports, frames.
#include "core/base/frame.h"

#include "bindings/bindings.h"

namespace loomstone {

namespace {

void bind_errors(py::module_& m) {
  static py::exception<Error> error(m, "Error", PyExc_Exception);
  error.attr("__doc__") = "Base of all errors of this library.";
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
  input.attr("__doc__") = "Something given cannot be simulated (a ValueError).";
  solver.attr("__doc__") = "A solve or a step failed; names stage, step and time (a RuntimeError).";
  cache.attr("__doc__") = "A file could not be written, read or understood (an OSError).";
  unsupported.attr("__doc__") = "Not offered in this build or combination (a NotImplementedError).";
  py::register_exception_translator([](std::exception_ptr failure) {
    try {
      if (failure) std::rethrow_exception(failure);
    } catch (const InvalidInput& e) {
      py::set_error(input, e.what());
    } catch (const SolverFailure& e) {
      py::set_error(solver, e.what());
    } catch (const CacheError& e) {
      py::set_error(cache, e.what());
    } catch (const Unsupported& e) {
      py::set_error(unsupported, e.what());
    } catch (const Error& e) {
      py::set_error(error, e.what());
    }
  });
}

py::dict seconds(const StepReport& report) {
  py::dict dict;
  for (std::size_t i = 0; i < stage_names.size(); ++i) dict[stage_names[i]] = report.seconds[i];
  return dict;
}

template <class Class, class Visit>
void each_number(Visit&& visit) {
  visit("step", &Class::step, "number of the step");
  visit("time", &Class::time, "at the end of the step [s]");
  visit("busy_least", &Class::busy_least,
        "time in the loops of collision detection and response, of the thread with the least [s]");
  visit("busy_mean", &Class::busy_mean, "the same, mean over the threads [s]");
  visit("busy_most", &Class::busy_most, "the same, of the thread with the most [s]");
  visit("newton_iterations", &Class::newton_iterations,
        "outer iterations; 1 for linearised schemes");
  visit("linear_iterations", &Class::linear_iterations,
        "of the linear solver, summed over outer iterations");
  visit("linear_residual", &Class::linear_residual, "of the last linear solve, relative [1]");
  visit("contacts", &Class::contacts, "proximity contacts that entered the solve");
  visit("impacts", &Class::impacts, "hits of the continuous test, first pass");
  visit("truncated", &Class::truncated, "vertices whose displacement was shortened");
  visit("substeps", &Class::substeps,
        "parts the step was taken in; more than 1 where certification failed at its full length");
  visit("unresolved", &Class::unresolved,
        "impacts that certification had to leave, even in 1/64 of the step");
  visit("intersections", &Class::intersections,
        "intersecting triangle pairs at the end of the step; counted from an unresolved step on "
        "until there are none");
  visit("forced", &Class::forced,
        "of the intersecting pairs, those left because what moves by script left the cloth no "
        "room; see sim.forced_pairs");
  visit("wanted_motion", &Class::wanted_motion,
        "lengths of the displacements that came to certification, summed over free cloth vertices "
        "[m]");
  visit("withheld_motion", &Class::withheld_motion,
        "lengths that truncation took from displacements of cloth and free bodies, summed [m]");
  visit("withheld", &Class::withheld, "withheld_motion over wanted_motion [1]");
  visit("truncated_momentum", &Class::truncated_momentum,
        "mass times change of velocity by truncation, sizes summed over vertices and bodies [kg "
        "m/s]");
  visit("contact_acceleration", &Class::contact_acceleration,
        "root mean square over free vertices in contact, over the whole step [m/s^2]");
  visit("limit_sweeps", &Class::limit_sweeps, "sweeps of strain limiting");
  visit("rate_sweeps", &Class::rate_sweeps, "sweeps of strain-rate limiting");
  visit("limit_rounds", &Class::limit_rounds,
        "certifications in turn with strain limiting; 1: limits held after the first");
  visit("limit_retreats", &Class::limit_retreats,
        "of these, those after cloth went back towards the start of the step because limits and "
        "contacts did not agree");
  visit("limit_evaluations", &Class::limit_evaluations,
        "elements whose strain was computed in the sweeps of strain limiting");
  visit("limit_excess", &Class::limit_excess,
        "largest strain beyond its limit right after limiting [1]");
  visit("weft_excess", &Class::weft_excess,
        "largest strain along weft beyond its limit at the end of the step [1]");
  visit("warp_excess", &Class::warp_excess,
        "largest strain along warp beyond its limit at the end of the step [1]");
  visit("shear_excess", &Class::shear_excess,
        "largest shear strain beyond its limit at the end of the step [1]");
  visit("beyond_limit", &Class::beyond_limit,
        "elements beyond a limit by more than the tolerance at the end of the step");
  visit("worst_element", &Class::worst_element,
        "the one most beyond its limit, all cloths end to end; -1: none");
  visit("broken_limits", &Class::broken_limits,
        "elements beyond a limit by more than 0.01 (a fifth of limits below 0.05); see "
        "sim.broken_limits");
  visit("weft_strain", &Class::weft_strain,
        "largest strain U - I along weft of all triangles, limited or not [1]");
  visit("warp_strain", &Class::warp_strain, "the same along warp [1]");
  visit("shear_strain", &Class::shear_strain,
        "largest shear strain, e12 of U - I, of either sign [1]");
  visit("max_stretch", &Class::max_stretch, "largest principal stretch of any triangle [1]");
  visit("kinetic_energy", &Class::kinetic_energy, "[J]");
  visit("membrane_energy", &Class::membrane_energy, "[J]");
  visit("bending_energy", &Class::bending_energy, "[J]");
  visit("gravity_energy", &Class::gravity_energy, "[J]");
  visit("contact_energy", &Class::contact_energy,
        "[J], at the start of the step; the other energies are those of its end");
  visit("body_kinetic_energy", &Class::body_kinetic_energy,
        "of rigid bodies, moving and turning [J]");
  visit("body_gravity_energy", &Class::body_gravity_energy, "of rigid bodies [J]");
  visit("magnetic_energy", &Class::magnetic_energy,
        "of magnets in one another's field and in the uniform one [J]");
  visit("magnetic_substeps", &Class::magnetic_substeps,
        "sub-steps that the motion of magnets took");
  visit("magnetic_error", &Class::magnetic_error,
        "largest estimated error of a force at the end of the step [N]");
  visit("circuit_current", &Class::circuit_current,
        "in the first circuit at the end of the step [A]");
  visit("circuit_energy", &Class::circuit_energy,
        "of the inductances of all circuits, own and mutual [J]");
  visit("circuit_heat", &Class::circuit_heat, "in the resistances of circuits since the start [J]");
  visit("circuit_supply", &Class::circuit_supply,
        "by the sources of all coils since the start [J]");
  visit("bearing_work", &Class::bearing_work,
        "taken out by friction and torques of bearings since the start [J]");
}

void bind_report(py::module_& m) {
  py::class_<StepReport> c(m, "StepReport", "What happened in a step; never decides anything.");
  c.def(py::init<>());
  each_number<StepReport>(
      [&](const char* name, auto member, const char* text) { c.def_readonly(name, member, text); });
  c.def_property_readonly("seconds", &seconds, "Wall time of each stage, by name [s].");
  c.def(
      "to_dict",
      [](const StepReport& report) {
        py::dict dict;
        each_number<StepReport>(
            [&](const char* name, auto member, const char*) { dict[name] = report.*member; });
        dict["seconds"] = seconds(report);
        return dict;
      },
      "All numbers by name.");
  c.def("__repr__", [](const StepReport& r) {
    return "StepReport(step=" + std::to_string(r.step) +
           ", time=" + py::str(py::cast(r.time)).cast<std::string>() +
           ", contacts=" + std::to_string(r.contacts) +
           ", linear_iterations=" + std::to_string(r.linear_iterations) + ")";
  });
}

void bind_frame_topology(py::module_& m) {
  using T = FrameTopology;
  py::class_<T> c(m, "FrameTopology",
                  "What stays the same over a run: cloths end to end, then rigid bodies and "
                  "obstacles end to end.");
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
  array("triangles", &T::triangles, "(m x 3) vertices of the cloth triangles");
  array("corner_uv", &T::corner_uv, "(3m x 2) rest coordinates of each triangle corner [m]");
  list("cloth_of_triangle", &T::cloth_of_triangle, "(m) index into cloth_names");
  list("cloth_of_vertex", &T::cloth_of_vertex, "(n) index into cloth_names");
  c.def_readonly("cloth_names", &T::cloth_names, "in the order of the scene");
  array("body_triangles", &T::body_triangles, "(mb x 3) triangles of rigid bodies and obstacles");
  list("body_of_triangle", &T::body_of_triangle, "(mb) index into body_names");
  list("body_of_vertex", &T::body_of_vertex, "(nb) index into body_names");
  c.def_readonly("body_names", &T::body_names, "rigid bodies first, then obstacles");
  list("body_pole", &T::body_pole,
       "(nb) 1 at north, -1 at south poles of magnets, 0 where there is none; or empty");
  list("body_is_floor", &T::body_is_floor, "(bodies) 1 where drawn as ground");
  c.def("__repr__", [](const T& self) {
    return "FrameTopology(" + std::to_string(self.cloth_of_vertex.size()) + " cloth vertices, " +
           std::to_string(self.triangles.rows()) + " cloth triangles, " +
           std::to_string(self.body_triangles.rows()) + " body triangles)";
  });
}

void bind_frame(py::module_& m) {
  py::class_<Frame> c(
      m, "Frame", "One instant of a run, in the user's vertex order; arrays are read-only views.");
  const auto array = [&](const char* name, auto member, const char* text) {
    c.def_property_readonly(
        name, [member](const Frame& self) -> const auto& { return self.*member; },
        py::return_value_policy::reference_internal, text);
  };
  c.def_readonly("time", &Frame::time, "[s]");
  c.def_readonly("step", &Frame::step, "number of the last step");
  array("positions", &Frame::positions, "(n x 3) of the cloth vertices [m]");
  array("velocities", &Frame::velocities, "(n x 3) [m/s]");
  array("strain", &Frame::strain, "(m x 3) Green strain weft, warp, shear (E12) [1]");
  array("stretch", &Frame::stretch, "(m) largest principal stretch [1]");
  c.def_property_readonly(
      "contact", [](py::object self) { return view(self.cast<const Frame&>().contact, self); },
      "(n) 1 where the vertex took part in a contact, 2 where it was forced to intersect");
  array("body_positions", &Frame::body_positions,
        "(nb x 3) vertices of rigid bodies and obstacles [m]");
  array("coil_currents", &Frame::coil_currents, "(coils) in all coils, given or of circuits [A]");
  c.def_readonly("report", &Frame::report, "StepReport of the last step");
  c.def(
      "with_contact",
      [](Frame self, std::vector<std::uint8_t> contact) {
        self.contact = std::move(contact);
        return self;
      },
      py::arg("contact"), "A copy with other contact flags, to mark vertices in a picture.");
  c.def("__repr__", [](const Frame& self) {
    return "Frame(time=" + py::str(py::cast(self.time)).cast<std::string>() +
           ", step=" + std::to_string(self.step) + ", " + std::to_string(self.positions.rows()) +
           " vertices)";
  });
}

}  // namespace

void bind_base(py::module_& m) {
  bind_errors(m);
  bind_report(m);
  bind_frame_topology(m);
  bind_frame(m);
}

}  // namespace loomstone
