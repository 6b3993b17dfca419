// Declared fields. A struct of user input, or a report, has a function fields() that declares each
// field once, with name, unit, limits and meaning. Validation, Python bindings, repr and the digest
// of a scene all read this list.
//
//   struct Gas {
//     double density = 1.2;
//     static auto fields() {
//       return std::make_tuple(field("density", &Gas::density, "kg/m^3", non_negative(),
//                                    "density of the air"));
//     }
//   };
#pragma once

#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>

#include "core/base/automatic.h"
#include "core/base/error.h"

namespace loomstone {

// Interval of admissible numbers, which can be open at its lower end. NaN is never admissible.
// Infinity is admissible only if allow_infinite is set.
struct Limits {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_open = false;
  bool allow_infinite = false;

  bool contains(double value) const {
    if (std::isnan(value)) return false;
    if (std::isinf(value) && !allow_infinite) return false;
    return (low_open ? value > low : value >= low) && value <= high;
  }
};

inline Limits unlimited() { return {}; }
inline Limits positive() { return {0.0, std::numeric_limits<double>::infinity(), true, false}; }
inline Limits non_negative() {
  return {0.0, std::numeric_limits<double>::infinity(), false, false};
}
inline Limits between(double low, double high) { return {low, high, false, false}; }

// Returns a string such as "> 0", ">= 0", "in [a, b]" or "finite".
std::string to_text(const Limits& limits);

template <class Owner, class Member>
struct Field {
  const char* name;
  Member Owner::* member;
  const char* unit;  // "1" if dimensionless; "" if none applies or `meaning` states it
  Limits limits;     // applies to numbers only
  const char* meaning;
};

template <class Owner, class Member>
Field<Owner, Member> field(const char* name, Member Owner::* member, const char* unit,
                           Limits limits, const char* meaning) {
  return {name, member, unit, limits, meaning};
}

template <class Owner, class Member>
Field<Owner, Member> field(const char* name, Member Owner::* member, const char* meaning) {
  return {name, member, "", {}, meaning};
}

// A field without a default value, so users must set it.
template <class Owner, class Member>
struct RequiredField : Field<Owner, Member> {};

template <class Owner, class Member>
RequiredField<Owner, Member> required_field(const char* name, Member Owner::* member,
                                            const char* unit, Limits limits, const char* meaning) {
  return {{name, member, unit, limits, meaning}};
}

template <class Owner, class Member>
constexpr bool is_required(const Field<Owner, Member>&) {
  return false;
}
template <class Owner, class Member>
constexpr bool is_required(const RequiredField<Owner, Member>&) {
  return true;
}

template <class Description, class Visitor>
void for_each_field(Visitor&& visit) {
  std::apply([&](const auto&... each) { (visit(each), ...); }, Description::fields());
}

// Throws InvalidInput with a message such as "cloths[0].material.density must be > 0 [kg/m^2], got
// -1; ...".
[[noreturn]] void throw_outside_limits(const std::string& where, const char* name, const char* unit,
                                       const Limits& limits, double value);

template <class Description>
void check_fields(const Description& description, const std::string& where) {
  for_each_field<Description>([&](const auto& each) {
    using Member = std::decay_t<decltype(description.*(each.member))>;
    const auto check = [&](double value) {
      if (!each.limits.contains(value))
        throw_outside_limits(where, each.name, each.unit, each.limits, value);
    };
    if constexpr (std::is_arithmetic_v<Member> && !std::is_same_v<Member, bool>)
      check(static_cast<double>(description.*(each.member)));
    else if constexpr (std::is_same_v<Member, std::optional<double>>)
      if (description.*(each.member)) check(*(description.*(each.member)));
    if constexpr (std::is_same_v<Member, Automatic>)
      if ((description.*(each.member)).given) check(*(description.*(each.member)).given);
  });
}

}  // namespace loomstone
