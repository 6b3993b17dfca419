// Error messages with values in them, formatted by {fmt}; the only file that includes it.
//
//   fail<InvalidInput>("steps must be >= 1, got {}; give at least one", steps);
//   fail<SolverFailure>("residual {:.3g} after {} iterations; ...", residual, iterations);
//
// A number is printed by {} with the fewest digits that give the same number back.
#pragma once

#include <fmt/core.h>

#include <string>

#include "core/base/error.h"

namespace loomstone {

std::string formatted_text(fmt::string_view text, fmt::format_args values);

// Throws a Failure (one of error.h) with this text.
template <class Failure>
[[noreturn]] void fail_formatted(fmt::string_view text, fmt::format_args values);

extern template void fail_formatted<Error>(fmt::string_view, fmt::format_args);
extern template void fail_formatted<InvalidInput>(fmt::string_view, fmt::format_args);
extern template void fail_formatted<SolverFailure>(fmt::string_view, fmt::format_args);
extern template void fail_formatted<CacheError>(fmt::string_view, fmt::format_args);
extern template void fail_formatted<Unsupported>(fmt::string_view, fmt::format_args);

// The compiler checks the text against the values.
template <class Failure, class... Values>
[[noreturn]] void fail(fmt::format_string<Values...> text, Values&&... values) {
  fail_formatted<Failure>(text, fmt::make_format_args(values...));
}

// The text alone, for messages that are put together from several.
template <class... Values>
[[nodiscard]] std::string formatted(fmt::format_string<Values...> text, Values&&... values) {
  return formatted_text(text, fmt::make_format_args(values...));
}

}  // namespace loomstone
