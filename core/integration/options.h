// Which integrator advances the cloth, and how. Method.md 1.4.
#pragma once

#include <string>

#include "core/base/field.h"

namespace loomstone {

// Description.
struct IntegratorOptions {
  // "semi-implicit-euler" | "explicit-euler" | "symplectic-euler" | "backward-euler" |
  // "implicit-midpoint" | "nonlinear-midpoint" | "bdf2"
  std::string method = "semi-implicit-euler";
  double step = 1e-3;
  std::string jacobian = "spd";       // "spd" | "exact"
  std::string bending = "auto";       // "auto" | "explicit" | "implicit"
  std::string linear_solver = "pcg";  // "pcg" | "block-jacobi" | "gauss-seidel" | "direct"
  double tolerance = 1e-4;
  int max_iterations = 2000;
  double newton_tolerance = 1e-6;
  int max_newton_iterations = 100;

  // Explicit and symplectic Euler, which solve no system.
  bool is_explicit() const { return method == "explicit-euler" || method == "symplectic-euler"; }

  static auto fields() {
    using O = IntegratorOptions;
    return std::make_tuple(
        field("method", &O::method, "name of the integrator"),
        field("step", &O::step, "s", positive(), "time step"),
        field("jacobian", &O::jacobian, "spd (positive part of the geometric term) | exact"),
        field("bending", &O::bending, "auto | explicit | implicit"),
        field("linear_solver", &O::linear_solver, "pcg | block-jacobi | gauss-seidel | direct"),
        field("tolerance", &O::tolerance, "1", positive(),
              "of the linear solver, on the preconditioned norm"),
        field("max_iterations", &O::max_iterations, "1", between(1, 1e9), "of the linear solver"),
        field("newton_tolerance", &O::newton_tolerance, "1", positive(),
              "relative residual of the Newton loop"),
        field("max_newton_iterations", &O::max_newton_iterations, "1", between(1, 1e6),
              "of the Newton loop"));
  }
};

}  // namespace loomstone
