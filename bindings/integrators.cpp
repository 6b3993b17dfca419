// Binds a Python class for each integrator.
#include "bindings/integrators.h"

#include "bindings/descriptions.h"

namespace loomstone {

namespace {

template <class Method>
void bind_method(py::module_& m, const char* name, const char* meaning) {
  auto c = bind_description<Method, 0, IntegratorCommon>(m, name, meaning);
  c.attr("method") = py::str(Method::name.data(), Method::name.size());
}

// Binds the base class of all integrators. This class has only the field `step`. For a derived
// class, bind_method() binds all fields, including `step`.
void bind_common(py::module_& m) {
  py::class_<IntegratorCommon> c(
      m, "Integrator",
      "Base class of the integrators that advance the cloth, such as SemiImplicitEuler.");
  c.def_property_readonly(
      "step", [](const IntegratorCommon& self) { return self.step; }, "time step [s], or auto");
  c.attr("method") = "";  // name on the command line and in files, set by each derived class
  c.def(
      "replace",
      [](const py::object& self, const py::kwargs& changes) {
        return self.attr("replace")(**changes);
      },
      "Returns a copy with the given fields changed.");
  c.def(
      "to_dict", [](const py::object& self) { return self.attr("to_dict")().cast<py::dict>(); },
      "Returns plain values for JSON.");
}

}  // namespace

void bind_integrators(py::module_& m) {
  bind_common(m);
  bind_method<ExplicitEuler>(
      m, "ExplicitEuler",
      "Explicit Euler, order 1. Gains energy and needs tiny steps; intended for comparisons only.");
  bind_method<SymplecticEuler>(m, "SymplecticEuler",
                               "Symplectic Euler, order 1, which updates velocities first. "
                               "Conserves energy on average. Stable for small steps only.");
  bind_method<SemiImplicitEuler>(m, "SemiImplicitEuler",
                                 "Backward Euler with one linear solve per step (Baraff and Witkin "
                                 "1998), order 1. Robust, with numerical damping.\n"
                                 "This is the default integrator.");
  bind_method<BackwardEuler>(m, "BackwardEuler",
                             "Backward Euler solved by Newton's method with line search, order 1. "
                             "The converged form of SemiImplicitEuler.");
  bind_method<ImplicitMidpoint>(m, "ImplicitMidpoint",
                                "Linearised implicit midpoint rule with one linear solve per step, "
                                "order 2. Little numerical damping. While cloth is at its strain "
                                "limits, anything touches or energy has risen, steps are taken by "
                                "backward Euler.");
  bind_method<NonlinearMidpoint>(m, "NonlinearMidpoint",
                                 "Implicit midpoint rule solved by Newton's method with line "
                                 "search, order 2. Little numerical damping. While cloth is at its "
                                 "strain limits, anything touches or energy has risen, steps are "
                                 "taken by backward Euler.");
  bind_method<Bdf2>(m, "BDF2",
                    "Linearised second-order backward differences (Choi and Ko 2002), order 2. "
                    "Less numerical damping than Euler. While cloth is at its strain limits, "
                    "anything touches or energy has risen, steps are taken by backward Euler.");
  bind_method<Asynchronous>(
      m, "Asynchronous",
      "Asynchronous variational integrator: every triangle has its own explicit step. Order 2 with "
      "nested steps. Conserves energy on average.");
}

}  // namespace loomstone
