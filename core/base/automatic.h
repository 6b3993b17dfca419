// A number that users either give or leave to the program by writing "auto".
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
