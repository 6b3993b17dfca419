// Options of the integrators, one struct per scheme. See docs/method.md, "Integrators".
#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <tuple>
#include <utility>
#include <variant>

#include "core/base/choice.h"
#include "core/base/field.h"
#include "core/cloth/material/jacobian_terms.h"
#include "core/linalg/linear_solver.h"

namespace loomstone {

constexpr auto choices(JacobianKind) {
  return std::array{
      ChoiceName{JacobianKind::Positive, "spd", "positive semidefinite part of the geometric term"},
      ChoiceName{JacobianKind::Exact, "exact"}};
}

enum class BendingInStep { Auto, Explicit, Implicit };
constexpr auto choices(BendingInStep) {
  return std::array{ChoiceName{BendingInStep::Auto, "auto",
                               "implicit where explicit bending would be unstable or nearly so"},
                    ChoiceName{BendingInStep::Explicit, "explicit"},
                    ChoiceName{BendingInStep::Implicit, "implicit"}};
}

enum class Schedule { Nested, Queue, Refill };
constexpr auto choices(Schedule) {
  return std::array{
      ChoiceName{Schedule::Nested, "nested",
                 "steps are the interval divided by a common number and by powers of two, order 2"},
      ChoiceName{Schedule::Queue, "queue",
                 "every triangle keeps its own step and phase, events are ordered in a heap, order "
                 "1; for comparison"},
      ChoiceName{
          Schedule::Refill, "refill",
          "every interval begins a new phase, as printed in Thomaszewski 2010; gains energy, "
          "for comparison"}};
}

enum class StepLimit { Eigenvalue, Inradius };
constexpr auto choices(StepLimit) {
  return std::array{
      ChoiceName{
          StepLimit::Eigenvalue, "eigenvalue",
          "computed from the highest frequency of the triangle; for every shape and material"},
      ChoiceName{StepLimit::Inradius, "inradius",
                 "computed from the time in which a wave crosses the inscribed circle"}};
}

enum class Limiting { Potential, Impulses, None };
constexpr auto choices(Limiting) {
  return std::array{ChoiceName{Limiting::Potential, "potential",
                               "membrane with two further phases, which add 30 and 90 times its "
                               "modulus"},
                    ChoiceName{Limiting::Impulses, "impulses",
                               "one correction of velocities in each event; does not keep energy"},
                    ChoiceName{Limiting::None, "none", "limits are only reported"}};
}

// Options that all schemes have.
struct IntegratorCommon {
  Automatic step;
};

// Options of explicit and symplectic Euler.
struct ExplicitOptions : IntegratorCommon {
  static auto fields() {
    return std::make_tuple(field("step", &ExplicitOptions::step, "s", positive(),
                                 "time step; auto: half the stable step at the start, divided if "
                                 "cloth becomes so stiff that it would be unstable"));
  }
};

// Options that linearised schemes and Newton schemes have in common.
struct ImplicitOptions : IntegratorCommon {
  JacobianKind jacobian = JacobianKind::Positive;
  BendingInStep bending = BendingInStep::Auto;
  LinearMethod linear_solver = LinearMethod::Pcg;
  double tolerance = 1e-4;
  int max_iterations = 2000;
  std::optional<double> accuracy = 1.0;

  static auto fields() {
    using O = ImplicitOptions;
    return std::make_tuple(
        field("step", &O::step, "s", positive(),
              "time step, taken in parts where its error is too large; auto: steps of the length "
              "that the error allows, at most 10 ms for implicit Euler without rigid bodies, else "
              "1 ms"),
        field("jacobian", &O::jacobian, "Jacobian of the membrane's forces"),
        field("bending", &O::bending, "treatment of bending forces"),
        field("linear_solver", &O::linear_solver, "solver of the linear system"),
        field(
            "tolerance", &O::tolerance, "1", Limits{0.0, 0.1, true, false},
            "tolerance of the linear solver relative to the change of momentum in the step or to a "
            "tenth of that by gravity, if this is larger; a hundredth of this value applies to the "
            "linearised midpoint rule and BDF-2 while nothing touches"),
        field("max_iterations", &O::max_iterations, "1", between(1, 1e9),
              "largest number of iterations of the linear solver"),
        field("accuracy", &O::accuracy, "1", positive(),
              "tolerated error of a step as a multiple of the default; a step with a larger error "
              "is taken in parts; None: steps are taken as given"));
  }
};

// Options of schemes that solve the nonlinear equations of a step by Newton's method.
struct NewtonOptions : ImplicitOptions {
  double newton_tolerance = 1e-6;
  int max_newton_iterations = 100;

  static auto fields() {
    using O = NewtonOptions;
    return std::tuple_cat(
        ImplicitOptions::fields(),
        std::make_tuple(
            field("newton_tolerance", &O::newton_tolerance, "1", Limits{0.0, 0.1, true, false},
                  "relative residual at which Newton's method stops"),
            field("max_newton_iterations", &O::max_newton_iterations, "1", between(1, 1e6),
                  "largest number of Newton iterations")));
  }
};

// Options of each scheme.
struct ExplicitEuler : ExplicitOptions {
  static constexpr std::string_view name = "explicit-euler";
};
struct SymplecticEuler : ExplicitOptions {
  static constexpr std::string_view name = "symplectic-euler";
};
struct SemiImplicitEuler : ImplicitOptions {
  static constexpr std::string_view name = "semi-implicit-euler";
};
struct BackwardEuler : NewtonOptions {
  static constexpr std::string_view name = "backward-euler";
};
struct ImplicitMidpoint : ImplicitOptions {
  static constexpr std::string_view name = "implicit-midpoint";
};
struct NonlinearMidpoint : NewtonOptions {
  static constexpr std::string_view name = "nonlinear-midpoint";
};
struct Bdf2 : ImplicitOptions {
  static constexpr std::string_view name = "bdf2";
};

struct Asynchronous : IntegratorCommon {
  static constexpr std::string_view name = "asynchronous";
  static constexpr double default_step = 2.5e-3;

  Schedule schedule = Schedule::Nested;
  StepLimit limit = StepLimit::Eigenvalue;
  Automatic safety;
  double bending_multiple = 4.0;
  Limiting limiting = Limiting::Potential;
  std::optional<double> predicted;
  std::optional<double> present;

  Asynchronous() { step = default_step; }
  // Returns the length of a triangle's step as a fraction of the bound that `limit` selects: the
  // given safety, or the default for this bound.
  double given_safety() const {
    return safety.given.value_or(limit == StepLimit::Eigenvalue ? 0.4 : 0.6);
  }
  static auto fields() {
    using O = Asynchronous;
    return std::make_tuple(
        field("step", &O::step, "s", positive(),
              "interval at whose ends all triangles are at the same time; auto: 2.5 ms"),
        field("schedule", &O::schedule, "order of the triangles' steps"),
        field("limit", &O::limit, "bound of a triangle's step"),
        field("safety", &O::safety, "1", {0.0, 1.0, true, false},
              "step of a triangle as a fraction of its bound; auto: 0.4 for limit=\"eigenvalue\", "
              "0.6 for limit=\"inradius\""),
        field("bending_multiple", &O::bending_multiple, "1", between(0.0, 64.0),
              "largest step of bending as a multiple of the membrane's, at least 1, within "
              "the limit of bending itself; 0: bending acts in the events of the membrane"),
        field("limiting", &O::limiting, "method that enforces the strain limits of cloth"),
        field("predicted", &O::predicted, "1", positive(),
              "strain at which limiting begins, for impulses the strain that is predicted for the "
              "next event of a triangle; None: the limits of the cloth"),
        field("present", &O::present, "1", positive(),
              "present strain beyond which impulses also correct positions; None: 4/3 of the "
              "strain at which limiting begins"));
  }
};

// The scheme of a simulation together with its options.
class IntegratorOptions {
 public:
  using Methods = std::variant<SemiImplicitEuler, ExplicitEuler, SymplecticEuler, BackwardEuler,
                               ImplicitMidpoint, NonlinearMidpoint, Bdf2, Asynchronous>;

  IntegratorOptions() = default;
  template <class Method>
    requires std::is_constructible_v<Methods, Method>
  IntegratorOptions(Method method) : method_(std::move(method)) {}

  template <class Visitor>
  decltype(auto) visit(Visitor&& visitor) const {
    return std::visit(std::forward<Visitor>(visitor), method_);
  }
  template <class Method>
  bool is() const {
    return std::holds_alternative<Method>(method_);
  }

  std::string_view name() const {
    return visit([](const auto& method) { return method.name; });
  }
  Automatic step() const {
    return visit([](const auto& method) { return method.step; });
  }
  void set_step(double step) {
    std::visit([&](auto& method) { method.step = step; }, method_);
  }
  // implicit() and newton() return the options that a family of schemes has in common, or null if
  // the scheme does not belong to that family.
  ImplicitOptions* implicit() { return family<ImplicitOptions>(method_); }
  const ImplicitOptions* implicit() const { return family<const ImplicitOptions>(method_); }
  NewtonOptions* newton() { return family<NewtonOptions>(method_); }
  const NewtonOptions* newton() const { return family<const NewtonOptions>(method_); }

 private:
  template <class Family, class Held>
  static Family* family(Held& held) {
    return std::visit(
        [](auto& method) -> Family* {
          if constexpr (std::is_convertible_v<decltype(&method), Family*>) return &method;
          return nullptr;
        },
        held);
  }

  Methods method_;
};

// Returns the scheme with this name (see IntegratorOptions::name()) and default options. Throws
// InvalidInput if there is no such scheme.
IntegratorOptions integrator_named(std::string_view name);

}  // namespace loomstone
