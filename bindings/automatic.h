// Converts Automatic (core/base/automatic.h) to and from a Python number or the string "auto".
#pragma once

#include <string_view>

#include "bindings/bindings.h"
#include "core/base/automatic.h"

namespace pybind11::detail {

template <>
struct type_caster<loomstone::Automatic> {
  PYBIND11_TYPE_CASTER(
      loomstone::Automatic,
      io_name("typing.SupportsFloat | typing.SupportsIndex | typing.Literal[\"auto\"]",
              "float | typing.Literal[\"auto\"]"));

  bool load(handle source, bool convert) {
    if (isinstance<str>(source)) {
      value = {};
      return source.cast<std::string_view>() == "auto";
    }
    make_caster<double> number;
    if (!number.load(source, convert)) return false;
    value = cast_op<double>(number);
    return true;
  }
  static handle cast(const loomstone::Automatic& number, return_value_policy, handle) {
    if (number.given) return PyFloat_FromDouble(*number.given);
    return pybind11::str("auto").release();
  }
};

}  // namespace pybind11::detail
