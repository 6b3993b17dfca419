// Enums whose values users select by name. Next to each enum, an overload of choices() lists the
// names and meanings of its values. Input validation, Python's Literal types and help texts use
// this list. The overload is found by argument-dependent lookup:
//
//   enum class RestAngles { Flat, Mesh };
//   constexpr auto choices(RestAngles) {
//     return std::array{ChoiceName{RestAngles::Flat, "flat", "zero"},
//                       ChoiceName{RestAngles::Mesh, "mesh", "those of the mesh as given"}};
//   }
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace loomstone {

template <class Enum>
struct ChoiceName {
  Enum value;
  std::string_view name;
  std::string_view meaning = {};
};
template <class Enum>
ChoiceName(Enum, const char*) -> ChoiceName<Enum>;
template <class Enum>
ChoiceName(Enum, const char*, const char*) -> ChoiceName<Enum>;

template <class T>
concept Choice = std::is_enum_v<T> && requires(T value) { choices(value); };

template <Choice Enum>
constexpr std::string_view name_of(Enum value) {
  for (const auto& each : choices(Enum{}))
    if (each.value == value) return each.name;
  return {};
}

template <Choice Enum>
std::vector<std::string_view> choice_names() {
  std::vector<std::string_view> names;
  for (const auto& each : choices(Enum{})) names.push_back(each.name);
  return names;
}

// Returns a string such as "uv (meaning) | mesh (meaning)".
std::string choices_text(const std::vector<std::string_view>& names,
                         const std::vector<std::string_view>& meanings);
template <Choice Enum>
std::string choices_text() {
  std::vector<std::string_view> meanings;
  for (const auto& each : choices(Enum{})) meanings.push_back(each.meaning);
  return choices_text(choice_names<Enum>(), meanings);
}

// Throws InvalidInput with a message that lists all names and, if one of them is close to `given`,
// suggests it.
[[noreturn]] void throw_no_choice(std::string_view where,
                                  const std::vector<std::string_view>& names,
                                  std::string_view given);

// Returns the choice called `name`. Throws InvalidInput if there is none. `where` is the name of
// the field in the message.
template <Choice Enum>
Enum choice_named(std::string_view name, std::string_view where) {
  for (const auto& each : choices(Enum{}))
    if (each.name == name) return each.value;
  throw_no_choice(where, choice_names<Enum>(), name);
}

}  // namespace loomstone
