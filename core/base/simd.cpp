#include "core/base/simd.h"

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <string>

#include "core/base/message.h"

namespace loomstone {

namespace {

constexpr const char* variable = "LOOMSTONE_INSTRUCTIONS";

InstructionSet of_processor() {
#if LOOMSTONE_SEVERAL_SETS
  if (__builtin_cpu_supports("x86-64-v4")) return InstructionSet::v4;
  if (__builtin_cpu_supports("x86-64-v3")) return InstructionSet::v3;
#endif
  return InstructionSet::baseline;
}

// Returns the widest instruction set that the environment variable LOOMSTONE_INSTRUCTIONS allows,
// or nullopt if the value of the variable is unknown. If the variable is unset or empty, all sets
// are allowed.
std::optional<InstructionSet> allowed() {
  const char* text = std::getenv(variable);
  const std::string name = text && *text ? text : "x86-64-v4";
  if (name == "x86-64") return InstructionSet::baseline;
  if (name == "x86-64-v3") return InstructionSet::v3;
  if (name == "x86-64-v4") return InstructionSet::v4;
  return std::nullopt;
}

}  // namespace

const InstructionSet instruction_set =
    std::min(of_processor(), allowed().value_or(InstructionSet::v4));

void check_instruction_set() {
  if (!allowed())
    fail<InvalidInput>(
        "the environment variable {} must be x86-64, x86-64-v3 or x86-64-v4, got '{}'; unset it to "
        "use the widest set of the processor",
        variable, std::getenv(variable));
}

}  // namespace loomstone
