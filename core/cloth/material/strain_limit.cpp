#include "core/cloth/material/strain_limit.h"

#include "core/base/message.h"

namespace loomstone {

void check_limit_options(const LimitOptions& options, const std::string& where) {
  check_fields(options, where);
  for (const char* known : {"gauss-seidel", "gauss-seidel-random", "jacobi", "edges"})
    if (options.method == known) return;
  fail<InvalidInput>(
      "{}.method must be one of gauss-seidel | gauss-seidel-random | jacobi | edges, got \"{}\"; "
      "choose one",
      where, options.method);
}

}  // namespace loomstone
