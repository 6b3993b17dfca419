#include "core/base/message.h"

namespace loomstone {

std::string formatted_text(fmt::string_view text, fmt::format_args values) {
  return fmt::vformat(text, values);
}

template <class Failure>
void fail_formatted(fmt::string_view text, fmt::format_args values) {
  throw Failure(formatted_text(text, values));
}

template void fail_formatted<Error>(fmt::string_view, fmt::format_args);
template void fail_formatted<InvalidInput>(fmt::string_view, fmt::format_args);
template void fail_formatted<SolverFailure>(fmt::string_view, fmt::format_args);
template void fail_formatted<StepFailure>(fmt::string_view, fmt::format_args);
template void fail_formatted<CacheError>(fmt::string_view, fmt::format_args);
template void fail_formatted<Unsupported>(fmt::string_view, fmt::format_args);

}  // namespace loomstone
