// Converts IntegratorOptions to and from Python objects. In Python, each integrator is a class.
#pragma once

#include "bindings/bindings.h"
#include "core/integration/options.h"

namespace pybind11::detail {

template <>
struct type_caster<loomstone::IntegratorOptions> {
  PYBIND11_TYPE_CASTER(loomstone::IntegratorOptions,
                       make_caster<loomstone::IntegratorCommon>::name);

  bool load(handle source, bool) {
    return load_any(source, static_cast<loomstone::IntegratorOptions::Methods*>(nullptr));
  }
  static handle cast(const loomstone::IntegratorOptions& options, return_value_policy, handle) {
    return options.visit([](const auto& method) { return pybind11::cast(method).release(); });
  }

 private:
  template <class... Method>
  bool load_any(handle source, std::variant<Method...>*) {
    return (load_as<Method>(source) || ...);
  }
  template <class Method>
  bool load_as(handle source) {
    if (!isinstance<Method>(source)) return false;
    value = source.cast<const Method&>();
    return true;
  }
};

}  // namespace pybind11::detail
