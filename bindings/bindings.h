// Declarations shared by the bindings: conversions between C++ types and Python objects such as
// numpy arrays, and the functions bind_...(), which module.cpp calls in the order of their
// declarations.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>
#include <tuple>
#include <vector>

#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "bindings/choices.h"
#include "core/base/message.h"
#include "core/base/types.h"

namespace loomstone {

namespace py = pybind11;

struct BrokenLimit;
struct Team;

void bind_base(py::module_& m);
void bind_mesh(py::module_& m);
void bind_parallel(py::module_& m);
void bind_rigid(py::module_& m);
void bind_magnetics(py::module_& m);
void bind_soft_bodies(py::module_& m);
void bind_scene(py::module_& m);
void bind_integrators(py::module_& m);
void bind_limits(py::module_& m);
void bind_collision(py::module_& m);
void bind_replay(py::module_& m);
void bind_cache(py::module_& m);
void bind_renderer(py::module_& m);
void bind_simulation(py::module_& m);

// Returns a team with the given number of threads. 0 means the number in OMP_NUM_THREADS or, if
// that is unset or invalid, one thread for each available processor. Throws InvalidInput for a
// negative number.
Team team_of(int threads);

// Converts broken strain limits to tuples (element, "weft" | "warp" | "shear", excess).
std::vector<std::tuple<Index, std::string, double>> named(const std::vector<BrokenLimit>& broken);

// Returns a read-only numpy view of a vector that belongs to `owner`, which the view keeps alive.
template <class T>
py::array_t<T> view(const std::vector<T>& values, py::handle owner) {
  py::array_t<T> array({static_cast<py::ssize_t>(values.size())},
                       {static_cast<py::ssize_t>(sizeof(T))}, values.data(), owner);
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

// Name and unit of an argument. The unit is "1" if the argument is dimensionless or if the Python
// package has already converted the argument to a plain number.
struct Argument {
  Argument(const char* argument, const char* its_unit = "1") : name(argument), unit(its_unit) {}
  const char* name;
  const char* unit;
};

// Converts a quantity of any Pint registry (such as loomstone.units), or a list or tuple that
// contains quantities, to plain numbers in `unit`. Returns other values unchanged. Throws
// InvalidInput for a quantity of another dimension. `where` is the name of the value in error
// messages.
inline py::object in_unit(const py::object& value, const char* unit, const std::string& where) {
  return py::module_::import("loomstone.base.quantities").attr("in_unit")(value, unit, where);
}

template <std::size_t n>
struct Text {
  consteval Text(const char (&text)[n]) { std::copy_n(text, n, value); }
  char value[n];
};

// A number passed as an argument. If it carries a unit, it is converted to `unit`.
template <Text unit>
struct In {
  double value = 0.0;
  operator double() const { return value; }
};

// Converts an array-like object to an array of type Scalar. Quantities are first converted to the
// unit of the argument. Throws InvalidInput for a quantity of another dimension, for entries that
// are not real numbers and, if Scalar is an integer type, for fractions and for numbers outside the
// range of Scalar.
template <class Scalar>
py::array_t<Scalar, py::array::c_style | py::array::forcecast> numbers(const py::object& object,
                                                                       const Argument& argument) {
  const char* const name = argument.name;
  const bool plain = py::isinstance<py::array>(object);
  const auto any = py::array::ensure(plain ? object : in_unit(object, argument.unit, name));
  if (!any) PyErr_Clear();
  const char kind = any ? any.dtype().kind() : 'O';
  if (std::string("buif").find(kind) == std::string::npos)
    fail<InvalidInput>(
        "{} must be an array of numbers, got {}", name,
        any && kind != 'O'
            ? "an array of " + py::str(any.dtype()).template cast<std::string>()
            : "a " + py::type::of(object).attr("__name__").template cast<std::string>());
  if (std::is_integral_v<Scalar> && kind != 'b' && any.size() > 0)
    for (const char* end : {"min", "max"}) {
      const double value = py::float_(any.attr(end)());
      if (value >= std::numeric_limits<Scalar>::min() &&
          value <= std::numeric_limits<Scalar>::max())
        continue;
      fail<InvalidInput>("{} must be whole numbers in [{}, {}], got {}", name,
                         std::numeric_limits<Scalar>::min(), std::numeric_limits<Scalar>::max(),
                         py::str(any.attr(end)()).template cast<std::string>());
    }
  const py::array_t<Scalar, py::array::c_style | py::array::forcecast> array(any);
  if (std::is_integral_v<Scalar> && kind == 'f' && any.size() > 0 &&
      !py::module_::import("numpy").attr("array_equal")(any, array).template cast<bool>())
    fail<InvalidInput>("{} must be whole numbers, got fractions", name);
  return array;
}

// Converts an object to a vector of fixed length n. Throws InvalidInput if numbers() does, or if
// the shape of the object is not (n,).
template <class Fixed>
Fixed as_vector(const py::object& object, const Argument& argument) {
  const auto array = numbers<double>(object, argument);
  constexpr py::ssize_t wanted = Fixed::SizeAtCompileTime;
  if (array.ndim() != 1 || array.shape(0) != wanted)
    fail<InvalidInput>("{} must have shape ({},), got {}", argument.name, wanted,
                       py::str(array.attr("shape")).template cast<std::string>());
  return Eigen::Map<const Fixed>(array.data());
}

// Converts an object to an (n x columns) array. Throws InvalidInput if numbers() does, if the
// object has another shape, or if `rows` >= 0 and n is not equal to `rows`.
template <class Array>
Array as_rows(const py::object& object, const Argument& argument, Eigen::Index rows = -1) {
  using Scalar = typename Array::Scalar;
  constexpr py::ssize_t columns = Array::ColsAtCompileTime;
  const auto array = numbers<Scalar>(object, argument);
  if (array.ndim() != 2 || array.shape(1) != columns || (rows >= 0 && array.shape(0) != rows)) {
    fail<InvalidInput>("{} must have shape ({}, {}), got {}", argument.name,
                       rows < 0 ? "n" : formatted("{}", rows), columns,
                       py::str(array.attr("shape")).template cast<std::string>());
  }
  return Eigen::Map<const Array>(array.data(), array.shape(0), columns);
}

}  // namespace loomstone

namespace pybind11::detail {

template <loomstone::Text unit>
struct type_caster<loomstone::In<unit>> {
  PYBIND11_TYPE_CASTER(loomstone::In<unit>,
                       const_name("typing.SupportsFloat | typing.SupportsIndex"));

  bool load(handle source, bool convert) {
    object number = reinterpret_borrow<object>(source);
    if (hasattr(source, "dimensionality"))
      number = loomstone::in_unit(number, unit.value, "the argument");
    make_caster<double> caster;
    if (!caster.load(number, convert)) return false;
    value.value = cast_op<double>(caster);
    return true;
  }
};

}  // namespace pybind11::detail
