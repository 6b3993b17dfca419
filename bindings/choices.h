// Converts enums with named values (core/base/choice.h) to and from Python strings. In Python
// signatures, such an enum has the type Literal[...] with the names of its values.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include <pybind11/pybind11.h>

#include "core/base/choice.h"

namespace loomstone {

// The type of a choice in Python signatures, such as "typing.Literal['a', 'b']".
template <Choice Enum>
struct LiteralText {
  static constexpr std::string_view begin = "typing.Literal[", end = "]";
  static constexpr std::size_t size = [] {
    std::size_t n = begin.size() + end.size();
    bool first = true;
    for (const auto& each : choices(Enum{})) n += each.name.size() + (first ? 2 : 4), first = false;
    return n;
  }();
  char text[size + 1] = {};

  constexpr LiteralText() {
    std::size_t at = 0;
    const auto add = [&](std::string_view part) {
      for (const char letter : part) text[at++] = letter;
    };
    add(begin);
    bool first = true;
    for (const auto& each : choices(Enum{})) {
      add(first ? "'" : ", '"), add(each.name), add("'");
      first = false;
    }
    add(end);
  }
};

}  // namespace loomstone

namespace pybind11::detail {

template <loomstone::Choice Enum>
struct type_caster_enum_type_enabled<Enum> : std::false_type {};

template <loomstone::Choice Enum>
struct type_caster<Enum> {
  static constexpr loomstone::LiteralText<Enum> literal{};
  PYBIND11_TYPE_CASTER(Enum, descr<loomstone::LiteralText<Enum>::size>(literal.text));

  bool load(handle source, bool) {
    if (!isinstance<str>(source)) return false;
    const auto given = source.cast<std::string>();
    for (const auto& each : choices(Enum{}))
      if (each.name == given) {
        value = each.value;
        return true;
      }
    return false;
  }
  static handle cast(Enum value, return_value_policy, handle) {
    const std::string_view name = loomstone::name_of(value);
    return str(name.data(), name.size()).release();
  }
};

}  // namespace pybind11::detail
