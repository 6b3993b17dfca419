// Formatted error messages. Only this file includes {fmt}.
//
//   fail<InvalidInput>("steps must be >= 1, got {}; give at least one", steps);
//   fail<SolverFailure>("residual {:.3g} after {} iterations; ...", residual, iterations);
//   require(steps >= 1, "steps must be >= 1, got {}; give at least one", steps);
//
// {} prints a number with the fewest digits from which it can be restored exactly.
#pragma once

#include <fmt/core.h>

#include <string>

#include "core/base/error.h"

namespace loomstone {

std::string formatted_text(fmt::string_view text, fmt::format_args values);

// Throws an error of type Failure, one of the classes in error.h, with the formatted text.
template <class Failure>
[[noreturn]] void fail_formatted(fmt::string_view text, fmt::format_args values);

extern template void fail_formatted<Error>(fmt::string_view, fmt::format_args);
extern template void fail_formatted<InvalidInput>(fmt::string_view, fmt::format_args);
extern template void fail_formatted<SolverFailure>(fmt::string_view, fmt::format_args);
extern template void fail_formatted<StepFailure>(fmt::string_view, fmt::format_args);
extern template void fail_formatted<CacheError>(fmt::string_view, fmt::format_args);
extern template void fail_formatted<Unsupported>(fmt::string_view, fmt::format_args);

// Throws an error of type Failure with the formatted text. The compiler checks that the format
// string fits the values.
template <class Failure, class... Values>
[[noreturn]] void fail(fmt::format_string<Values...> text, Values&&... values) {
  fail_formatted<Failure>(text, fmt::make_format_args(values...));
}

// Throws InvalidInput with the formatted text if `holds` is false.
template <class... Values>
void require(bool holds, fmt::format_string<Values...> text, Values&&... values) {
  if (!holds) fail_formatted<InvalidInput>(text, fmt::make_format_args(values...));
}

// Returns the formatted text, for example as a part of a message.
template <class... Values>
[[nodiscard]] std::string formatted(fmt::format_string<Values...> text, Values&&... values) {
  return formatted_text(text, fmt::make_format_args(values...));
}

}  // namespace loomstone
