// Converts Python values to the members of descriptions, which are structs with a function fields()
// (core/base/field.h). If a value or an element of a list has the wrong type, an error names the
// field and, in a list, the index of the element.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "bindings/bindings.h"
#include "core/cloth/material/material.h"
#include "core/mesh/triangle_mesh.h"

namespace loomstone {

template <class T>
concept Description = requires { T::fields(); };

template <class T>
struct ListOf : std::false_type {};
template <class T>
struct ListOf<std::vector<T>> : std::true_type {
  using Element = T;
};
template <class T>
struct OptionalOf : std::false_type {};
template <class T>
struct OptionalOf<std::optional<T>> : std::true_type {
  using Value = T;
};

inline std::string type_name(const py::handle& value) {
  return py::type::handle_of(value).attr("__name__").cast<std::string>();
}

// Returns the repr of a value, cut to at most 200 characters.
inline std::string shown(const py::handle& value) {
  return py::object(py::repr(value)[py::slice(0, 200, 1)]).cast<std::string>();
}

// Returns whether all elements of a list are whole numbers or truth values.
inline bool all_whole(const py::object& list) {
  for (const py::handle each : list) {
    const py::object index = py::reinterpret_steal<py::object>(PyNumber_Index(each.ptr()));
    if (!index) PyErr_Clear();
    if (!index && type_name(each).rfind("bool", 0) != 0) return false;
  }
  return true;
}

// Converts a value and assigns it to `member`. Returns false if it cannot be converted.
template <class Member>
bool loaded(const py::object& value, Member& member) {
  try {
    py::detail::make_caster<Member> caster;
    // Conversion would cut off the fraction of a Decimal or of a float of NumPy.
    constexpr bool whole = std::is_integral_v<Member> && !std::is_same_v<Member, bool>;
    if (!caster.load(value, !whole)) return false;
    if constexpr (ListOf<Member>::value)
      if (std::is_integral_v<typename ListOf<Member>::Element> && !all_whole(value)) return false;
    member = py::detail::cast_op<Member&>(caster);
    return true;
  } catch (const py::reference_cast_error&) {  // the value is None and Member is a bound class
    return false;
  }
}

// Returns the name of type T for messages, or an empty string if the type has no such name.
template <class T>
std::string kind_name() {
  if constexpr (Description<T>)
    return py::type::of<T>().attr("__name__").template cast<std::string>();
  else if constexpr (std::is_same_v<T, std::shared_ptr<const TriangleMesh>>)
    return "TriangleMesh";
  else if constexpr (std::is_integral_v<T>)
    return "whole number";
  else if constexpr (std::is_floating_point_v<T>)
    return "number";
  else if constexpr (OptionalOf<T>::value)
    return kind_name<typename OptionalOf<T>::Value>();
  else
    return "";
}

[[noreturn]] inline void throw_wrong_kind(const std::string& where, const std::string& kind,
                                          const py::handle& value, const std::string& hint) {
  const bool vowel = std::string("AEIO").find(kind[0]) != std::string::npos;
  throw py::type_error(where + " must be " + (vowel ? "an " : "a ") + kind + ", got " +
                       (value.is_none() ? "" : "the " + type_name(value) + " ") + shown(value) +
                       hint);
}

// Returns a hint on how to make or read a TriangleMesh, given a value of another type. The hint is
// empty for None.
inline std::string mesh_hint(const py::object& value) {
  if (value.is_none()) return "";
  if (py::isinstance<py::str>(value) || py::hasattr(value, "__fspath__"))
    return "; read the file with loomstone.meshes.read(path)";
  return "; create one with TriangleMesh(vertices, triangles), or read a file with "
         "loomstone.meshes.read(path)";
}

// Throws a TypeError that names the required type of a field. If the field and the value are lists,
// the message names the first element of another type. Does nothing if there is no such element, or
// if the field is a number or an optional floating-point number. Also does nothing if kind_name()
// is empty for the type of the field (for a list, the type of its elements).
template <class Member>
void explain_kind(const std::string& where, const py::object& value) {
  if constexpr (ListOf<Member>::value) {
    using Element = typename ListOf<Member>::Element;
    const std::string kind = kind_name<Element>();
    if (kind.empty()) return;
    const bool text = py::isinstance<py::str>(value) || py::isinstance<py::bytes>(value);
    if (text || !py::isinstance<py::iterable>(value)) {
      Element element{};
      const std::string hint = loaded(value, element) ? "; put it into a list: [...]" : "";
      const bool number = std::is_arithmetic_v<Element>;
      throw_wrong_kind(where, "list of " + kind + (number ? "s" : ""), value, hint);
    }
    std::size_t index = 0;
    for (const py::handle each : value) {
      Element element{};
      if (each.is_none() || !loaded(py::reinterpret_borrow<py::object>(each), element))
        throw_wrong_kind(formatted("{}[{}]", where, index), kind, each, "");
      ++index;
    }
  } else if constexpr (!std::is_arithmetic_v<Member>) {
    const std::string kind = kind_name<Member>();
    if (kind.empty() || kind == "number") return;
    const bool fabric = std::is_same_v<Member, ClothMaterial> && py::isinstance<py::str>(value);
    const std::string hint = fabric ? "; a fabric is loomstone.fabrics[" + shown(value) + "]"
                             : kind == "TriangleMesh" ? mesh_hint(value)
                                                      : "";
    throw_wrong_kind(where, kind, value, hint);
  }
}

}  // namespace loomstone
