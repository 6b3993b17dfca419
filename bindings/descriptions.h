// Binds a description, a struct that lists its members in fields(). The constructor of the Python
// class takes the fields by keyword and, in some classes, the first fields by position. Defaults
// are those of C++. The class also has a read-only property for each field, equality by value,
// repr, to_dict() and replace(). The help texts of properties are made from fields().
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <type_traits>
#include <variant>

#include "bindings/automatic.h"
#include "bindings/bindings.h"
#include "bindings/kinds.h"
#include "bindings/textures.h"
#include "core/base/field.h"
#include "core/electrodynamics/magnet.h"
#include "core/electrodynamics/source_recipes.h"
#include "core/mesh/triangle_mesh.h"

namespace loomstone {

template <class T>
concept EigenArray = std::is_base_of_v<Eigen::MatrixBase<T>, T>;
template <class T>
concept Number = std::is_arithmetic_v<T>;

// --- equality by value ---
inline bool equal(const std::string& a, const std::string& b) { return a == b; }
template <class T>
  requires Number<T> || Choice<T>
bool equal(T a, T b) {
  return a == b;
}
template <EigenArray T>
bool equal(const T& a, const T& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() && (a.size() == 0 || a == b);
}
inline bool equal(const std::shared_ptr<const TriangleMesh>& a,
                  const std::shared_ptr<const TriangleMesh>& b) {
  if (a == b) return true;
  return a && b && equal(a->vertices(), b->vertices()) && equal(a->triangles(), b->triangles()) &&
         equal(a->uv(), b->uv()) && equal(a->uv_triangles(), b->uv_triangles());
}
inline bool equal(const Texture& a, const Texture& b) { return a == b || (a && b && *a == *b); }
inline bool equal(const RigidPose& a, const RigidPose& b) { return a == b; }
inline bool equal(const MagneticBody& a, const MagneticBody& b) {
  return equal(a.pose, b.pose) &&
         (a.source == b.source || a.source->recipe() == b.source->recipe());
}
inline bool equal(const SoftBody& a, const SoftBody& b) {
  return equal(a.pose, b.pose) && a.saturation == b.saturation &&
         (a.shape == b.shape || a.shape->recipe() == b.shape->recipe());
}
inline bool equal(const Automatic& a, const Automatic& b) { return a == b; }
inline bool equal(std::monostate, std::monostate) { return true; }
template <class... T>
bool equal(const std::variant<T...>& a, const std::variant<T...>& b) {
  return a.index() == b.index() &&
         std::visit(
             [&](const auto& value) {
               return equal(value, std::get<std::decay_t<decltype(value)>>(b));
             },
             a);
}
template <Description D>
bool equal(const D& a, const D& b);
template <class T>
bool equal(const std::optional<T>& a, const std::optional<T>& b) {
  return a.has_value() == b.has_value() && (!a || equal(*a, *b));
}
template <class T>
bool equal(const std::vector<T>& a, const std::vector<T>& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (!equal(a[i], b[i])) return false;
  return true;
}
template <Description D>
bool equal(const D& a, const D& b) {
  bool same = true;
  for_each_field<D>(
      [&](const auto& each) { same = same && equal(a.*(each.member), b.*(each.member)); });
  return same;
}

// --- conversion to plain Python values, for JSON ---
inline py::object plain(const std::string& value) { return py::cast(value); }
template <class T>
  requires Number<T> || Choice<T>
py::object plain(T value) {
  return py::cast(value);
}
template <EigenArray T>
py::object plain(const T& value) {
  return py::cast(value).attr("tolist")();
}
inline py::object plain(const std::shared_ptr<const TriangleMesh>& mesh) {
  py::dict counts;
  if (mesh) {
    counts["vertices"] = mesh->n_vertices();
    counts["triangles"] = mesh->n_triangles();
  }
  return counts;
}
inline py::object plain(const Texture& image) {
  if (!image) return py::none();
  py::dict size;
  size["width"] = image->width;
  size["height"] = image->height;
  return size;
}
inline py::dict plain(const SourceRecipe& recipe) {
  py::dict dict;
  dict["kind"] = recipe.kind;
  for (const auto& [name, value] : recipe.values)
    dict[py::str(name)] = std::visit([](const auto& v) -> py::object { return plain(v); }, value);
  if (recipe.mesh) dict["mesh"] = plain(recipe.mesh);
  if (recipe.of) dict["of"] = plain(*recipe.of);
  return dict;
}
inline py::dict with_pose(py::dict dict, const RigidPose& pose) {
  dict["position"] = plain(pose.position);
  dict["orientation"] = plain(pose.orientation);
  return dict;
}
inline py::object plain(const MagneticBody& body) {
  return with_pose(plain(body.source->recipe()), body.pose);
}
inline py::object plain(const SoftBody& body) {
  py::dict dict = plain(body.shape->recipe());
  dict["saturation"] = body.saturation;
  return with_pose(dict, body.pose);
}
inline py::object plain(std::monostate) { return py::none(); }
inline py::object plain(const Automatic& value) { return py::cast(value); }
template <class... T>
py::object plain(const std::variant<T...>& value) {
  return std::visit([](const auto& v) -> py::object { return plain(v); }, value);
}
template <Description D>
py::object plain(const D& value);
template <class T>
py::object plain(const std::optional<T>& value) {
  if (value) return plain(*value);
  return py::none();
}
template <class T>
py::object plain(const std::vector<T>& values) {
  py::list list;
  for (const T& value : values) list.append(plain(value));
  return list;
}
template <Description D>
py::object plain(const D& value) {
  py::dict dict;
  for_each_field<D>([&](const auto& each) { dict[each.name] = plain(value.*(each.member)); });
  return dict;
}

// --- repr, which lists required fields and all fields that differ from their defaults ---
template <class T>
std::string repr_of(const T& value) {
  if constexpr (EigenArray<T>) {
    if (T::RowsAtCompileTime == Eigen::Dynamic && value.size() > 12)
      return formatted("array({} x {})", value.rows(), value.cols());
    return py::repr(plain(value)).template cast<std::string>();
  } else if constexpr (std::is_same_v<T, Texture>) {
    return value ? formatted("image({} x {})", value->width, value->height) : "None";
  } else {
    const py::str text = py::repr(py::cast(value));
    return py::len(text) < 400 ? std::string(text)
                               : std::string(py::str(text[py::slice(0, 380, 1)])) + " ...]";
  }
}
template <Description D>
std::string repr_description(const D& value, const char* name) {
  const D defaults{};
  std::string text = std::string(name) + "(";
  bool first = true;
  for_each_field<D>([&](const auto& each) {
    if (!is_required(each) && equal(value.*(each.member), defaults.*(each.member))) return;
    text += std::string(first ? "" : ", ") + each.name + "=" + repr_of(value.*(each.member));
    first = false;
  });
  return text + ")";
}

template <Description D>
py::list field_names() {
  py::list names;
  for_each_field<D>([&](const auto& each) { names.append(each.name); });
  return names;
}

// Help text of a field: "meaning [unit]; limits; default ..." or, for a choice, "meaning: choices;
// default ...". Parts that do not apply are omitted.
template <class D, class F>
std::string field_text(const F& each) {
  using Member = std::decay_t<decltype(std::declval<D>().*(each.member))>;
  std::string text = each.meaning;
  if (*each.unit) text += std::string(" [") + each.unit + "]";
  if constexpr ((std::is_arithmetic_v<Member> && !std::is_same_v<Member, bool>) ||
                std::is_same_v<Member, std::optional<double>> ||
                std::is_same_v<Member, Automatic>) {
    const std::string limits = to_text(each.limits);
    if (limits != "finite") text += "; " + limits;
  }
  if constexpr (Choice<Member>) text += ": " + choices_text<Member>();
  if constexpr (std::is_arithmetic_v<Member> || std::is_same_v<Member, std::string> ||
                std::is_same_v<Member, Automatic> || Choice<Member>)
    if (!is_required(each)) text += "; default " + repr_of(D{}.*(each.member));
  return text;
}

// Unit of a field: the stated unit, or else the one in brackets in its meaning, or else "1".
template <class F>
std::string unit_of(const F& each) {
  if (*each.unit) return each.unit;
  const std::string meaning = each.meaning;
  const auto open = meaning.find('['), close = meaning.find(']', open);
  return open == std::string::npos ? "1" : meaning.substr(open + 1, close - open - 1);
}

template <class Member>
constexpr bool may_carry_unit =
    (std::is_arithmetic_v<Member> && !std::is_same_v<Member, bool>) ||
    std::is_same_v<Member, std::optional<double>> || std::is_same_v<Member, Automatic> ||
    std::is_same_v<Member, std::vector<double>> || EigenArray<Member>;

// If the type of the field may carry a unit (may_carry_unit), converts a value that carries a unit
// to plain numbers in the unit of the field, throws InvalidInput for a unit of another dimension,
// and throws a TypeError for a bool. Returns other values, and all values of other fields,
// unchanged.
template <class D, class F>
py::object plain_number(const py::object& value, const F& each, const char* name) {
  using Member = std::decay_t<decltype(std::declval<D>().*(each.member))>;
  if (!may_carry_unit<Member>) return value;
  if (PyBool_Check(value.ptr()))
    throw py::type_error(std::string(name) + "." + each.name + " must be a number [" +
                         unit_of(each) + "], got " + py::repr(value).template cast<std::string>());
  if (PyFloat_Check(value.ptr()) || PyLong_Check(value.ptr()) || value.is_none()) return value;
  if (std::is_same_v<Member, Automatic> && py::isinstance<py::str>(value)) return value;
  return in_unit(value, unit_of(each).c_str(), std::string(name) + "." + each.name);
}

// If a keyword is unknown, throws a TypeError that names the keyword and the most similar field, or
// all fields if none is similar.
inline void explain_keywords(const char* name, const py::list& known, const py::kwargs& arguments) {
  for (const auto& [key, value] : arguments) {
    if (known.contains(key)) continue;
    const auto close =
        py::module_::import("difflib").attr("get_close_matches")(key, known, 1).cast<py::list>();
    const std::string hint =
        close.empty() ? "; known: " + py::str(", ").attr("join")(known).cast<std::string>()
                      : "; did you mean '" + close[0].cast<std::string>() + "'?";
    throw py::type_error(std::string(name) + " has no field '" + key.cast<std::string>() + "'" +
                         hint);
  }
}

// Converts a value to a numpy array. Throws InvalidInput if its rows have different lengths.
inline py::object array_of(const std::string& where, const py::object& value) {
  try {
    return py::module_::import("numpy").attr("asarray")(value);
  } catch (py::error_already_set& error) {
    if (!error.matches(PyExc_ValueError)) throw;
    fail<InvalidInput>("{} must be numbers in rows of equal length, got {}", where, shown(value));
  }
}

// Throws an error that explains why a value cannot be assigned to a field.
template <Description D, class F>
[[noreturn]] void explain_value(const char* name, const F& each, const py::object& value) {
  using Member = std::decay_t<decltype(std::declval<D>().*(each.member))>;
  const std::string where = std::string(name) + "." + each.name;
  explain_kind<Member>(where, value);
  if constexpr (Choice<Member>)
    if (py::isinstance<py::str>(value))
      throw_no_choice(where, choice_names<Member>(), value.cast<std::string>());
  if constexpr (EigenArray<Member>) {
    const py::object array = array_of(where, value);
    const auto columns = Member::ColsAtCompileTime == 1
                             ? formatted("{},", int{Member::RowsAtCompileTime})
                             : formatted("n, {}", int{Member::ColsAtCompileTime});
    fail<InvalidInput>("{} must be numbers of shape ({}), got shape {} of {}", where, columns,
                       py::str(array.attr("shape")).cast<std::string>(),
                       py::str(array.attr("dtype")).cast<std::string>());
  }
  if (std::is_same_v<Member, Automatic> && py::isinstance<py::str>(value))
    throw py::type_error(where + " must be a number [" + unit_of(each) + "] or 'auto', got " +
                         shown(value));
  throw py::type_error(where + " (" + field_text<D>(each) + ") cannot be a " + type_name(value) +
                       ": got " + shown(value));
}

// Throws an error that explains why no D can be made from these keyword arguments: a name is
// unknown, or a value has the wrong type or shape.
template <Description D>
[[noreturn]] void explain_arguments(const char* name, const py::kwargs& arguments) {
  explain_keywords(name, field_names<D>(), arguments);
  for_each_field<D>([&](const auto& each) {
    if (!arguments.contains(each.name)) return;
    const py::object value = plain_number<D>(arguments[each.name], each, name);
    std::decay_t<decltype(std::declval<D>().*(each.member))> member{};
    if (!loaded(value, member)) explain_value<D>(name, each, value);
  });
  throw py::type_error(std::string(name) + ": the arguments cannot be converted");
}

// Returns the keyword arguments and, under the names of the first fields, the positional arguments.
// Throws a TypeError for more than n_positional positional arguments, or if a field is given twice.
template <Description D>
py::kwargs named_arguments(const char* name, std::size_t n_positional, const py::args& values,
                           const py::kwargs& keywords) {
  const py::list known = field_names<D>();
  if (values.size() > n_positional) {
    const std::string first = known[n_positional].template cast<std::string>();
    const std::string limit =
        n_positional == 0
            ? " takes keyword arguments only"
            : formatted(" takes at most {} arguments without a keyword", n_positional);
    throw py::type_error(name + limit + ", as in " + name + "(" + first + "=...), got " +
                         shown(py::object(values[n_positional])) + " without one");
  }
  const py::kwargs all(py::reinterpret_steal<py::object>(PyDict_Copy(keywords.ptr())));
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (all.contains(known[i]))
      throw py::type_error(name + std::string(" must get ") +
                           known[i].template cast<std::string>() +
                           " once, got it with and without its keyword");
    all[known[i]] = values[i];
  }
  return all;
}

// Throws a TypeError if the arguments lack a field that has no default.
template <Description D>
void require_arguments(const char* name, const py::kwargs& arguments) {
  for_each_field<D>([&](const auto& each) {
    if (is_required(each) && !arguments.contains(each.name))
      throw py::type_error(std::string(name) + " needs " + each.name + ": " + field_text<D>(each));
  });
}

// from_arguments() calls this function after it has set the fields of a description. This version
// does nothing. An overload for a class, such as Scene, completes the description.
template <Description D>
void complete(D&) {}

// from_arguments() calls this function before it sets the fields of a description. This version
// returns the arguments unchanged. An overload for a class, such as Cloth, changes the shape of an
// array in the arguments. The last parameter supplies fields that the arguments do not contain.
template <Description D>
py::kwargs reshaped(const char*, const py::kwargs& arguments, const D&) {
  return arguments;
}

template <Description D>
D from_arguments(const char* name, D value, const py::kwargs& given) {
  const py::kwargs arguments = reshaped(name, given, value);
  const py::list known = field_names<D>();
  bool good = true;
  for_each_field<D>([&](const auto& each) {
    if (!good || !arguments.contains(each.name)) return;
    good = loaded(plain_number<D>(arguments[each.name], each, name), value.*(each.member));
  });
  for (const auto& [key, unused] : arguments) good = good && known.contains(key);
  if (!good) explain_arguments<D>(name, arguments);
  complete(value);
  check_fields(value, name);
  return value;
}

// Binds two constructors. The first accepts any arguments, converts units and explains errors. The
// second has the full signature, for stubs and help.
template <Description D, class Class, std::size_t... P, std::size_t... K, class... F>
void bind_constructor(Class& c, const char* name, std::index_sequence<P...>,
                      std::index_sequence<K...>, const std::tuple<F...>& fields) {
  const D defaults{};
  const auto argument = [&]<class Each>(const Each& each) {
    if constexpr (is_required(Each{}))
      return py::arg(each.name);
    else
      return py::arg(each.name) = defaults.*(each.member);
  };
  c.def(py::init([name](const py::args& values, const py::kwargs& keywords) {
    const py::kwargs arguments = named_arguments<D>(name, sizeof...(P), values, keywords);
    require_arguments<D>(name, arguments);
    return from_arguments(name, D{}, arguments);
  }));
  c.def(py::init([name](const std::decay_t<decltype(std::declval<D>().*
                                                    (std::declval<F>().member))>&... values) {
          D value;
          std::apply([&](const auto&... f) { ((value.*(f.member) = values), ...); }, D::fields());
          check_fields(value, name);
          return value;
        }),
        argument(std::get<P>(fields))..., py::kw_only(),
        argument(std::get<sizeof...(P) + K>(fields))...);
}

// Binds D, whose base classes must already be bound. The constructor accepts the first n_positional
// fields as positional arguments.
template <Description D, std::size_t n_positional = 0, class... Bases>
py::class_<D, Bases...> bind_description(py::module_& m, const char* name,
                                         const std::string& meaning) {
  std::string doc =
      meaning +
      "\n\nImmutable; compared by value.\n\nParameters (keywords)\n---------------------\n";
  for_each_field<D>([&](const auto& each) {
    doc += std::string(each.name) + " : " + field_text<D>(each) + "\n";
  });
  py::class_<D, Bases...> c(m, name, doc.c_str());
  constexpr std::size_t n_fields = std::tuple_size_v<decltype(D::fields())>;
  bind_constructor<D>(c, name, std::make_index_sequence<n_positional>(),
                      std::make_index_sequence<n_fields - n_positional>(), D::fields());
  for_each_field<D>([&](const auto& each) {
    using Member = std::decay_t<decltype(std::declval<D>().*(each.member))>;
    const auto member = each.member;
    const std::string text = field_text<D>(each);
    c.def_property_readonly(
        each.name, [member](const D& self) -> Member { return self.*member; }, text.c_str());
  });
  c.def("__eq__", [](const D& a, const D& b) { return equal(a, b); }, py::is_operator());
  c.def("__repr__", [name](const D& self) { return repr_description(self, name); });
  c.def(
      "replace",
      [name](const D& self, const py::kwargs& changes) {
        return from_arguments(name, self, changes);
      },
      "Returns a copy with the given fields changed.");
  c.def(
      "to_dict", [](const D& self) { return plain(self); },
      "Returns the fields as plain values for JSON. A mesh is replaced by its numbers of vertices "
      "and triangles, and a texture by its size.");
  c.attr("field_names") = py::tuple(field_names<D>());
  return c;
}

}  // namespace loomstone
