// One class for each integrator, with the fields it has.
#include "bindings/integrators.h"

#include "bindings/descriptions.h"

namespace loomstone {

namespace {

template <class Method>
void bind_method(py::module_& m, const char* name, const char* meaning) {
  auto c = bind_description<Method, 0, IntegratorCommon>(m, name, meaning);
  c.attr("method") = py::str(Method::name.data(), Method::name.size());
}

// The common part of all integrators; each class binds all of its own fields.
void bind_common(py::module_& m) {
  py::class_<IntegratorCommon> c(m, "Integrator",
                                 "Which integrator advances the cloth, and how: the base of "
                                 "SemiImplicitEuler and the others.");
  c.def_property_readonly(
      "step", [](const IntegratorCommon& self) { return self.step; }, "time step [s]");
  c.attr("method") = "";  // of each class: its name on the command line and in files
  c.def(
      "replace",
      [](const py::object& self, const py::kwargs& changes) {
        return self.attr("replace")(**changes);
      },
      "A copy in which the given fields have other values.");
  c.def(
      "to_dict", [](const py::object& self) { return self.attr("to_dict")().cast<py::dict>(); },
      "Plain values for JSON.");
}

}  // namespace

void bind_integrators(py::module_& m) {
  bind_common(m);
  bind_method<ExplicitEuler>(
      m, "ExplicitEuler",
      "Explicit Euler, order 1: gains energy, needs tiny steps; for comparison.");
  bind_method<SymplecticEuler>(
      m, "SymplecticEuler",
      "Symplectic Euler, order 1: velocities first; keeps energy in the mean, stable for small "
      "steps only.");
  bind_method<SemiImplicitEuler>(
      m, "SemiImplicitEuler",
      "Backward Euler with one linear solve a step (Baraff and Witkin 1998), order 1: robust, "
      "damps. The default.");
  bind_method<BackwardEuler>(
      m, "BackwardEuler",
      "Backward Euler solved by Newton's method with line search, order 1: the semi-implicit one, "
      "converged.");
  bind_method<ImplicitMidpoint>(
      m, "ImplicitMidpoint",
      "Implicit midpoint rule, linearised: one linear solve a step, order 2, hardly damps.");
  bind_method<NonlinearMidpoint>(
      m, "NonlinearMidpoint",
      "Implicit midpoint rule solved by Newton's method with line search, order 2, hardly damps.");
  bind_method<Bdf2>(
      m, "BDF2",
      "Second-order backward differences, linearised (Choi and Ko 2002), order 2: damps less than "
      "Euler.");
}

}  // namespace loomstone
