// A number that the user gives, or that the program chooses if the user gives "auto".
#pragma once

#include <optional>

namespace loomstone {

struct Automatic {
  std::optional<double> given;  // empty: "auto"

  Automatic() = default;
  // NOLINTNEXTLINE(google-explicit-constructor): fields are set from plain numbers
  Automatic(double value) : given(value) {}
  bool operator==(const Automatic&) const = default;
};

}  // namespace loomstone
