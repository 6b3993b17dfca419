// Kinds of messages between the ranks of a TaskPool.
#pragma once

#include <cstdint>

namespace loomstone {

// Request: asks for a task. Refusal and Task: its answers. Wave, Counts and End: detection of
// termination (termination.h).
enum class PoolMessage : std::int32_t { Request, Refusal, Task, Wave, Counts, End };

}  // namespace loomstone
