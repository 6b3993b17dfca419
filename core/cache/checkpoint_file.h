// Checkpoint files, which store named arrays, integers, bytes and strings without loss. A file is
// written under a temporary name and then renamed.
#pragma once

#include <string>

#include "core/base/checkpoint.h"

namespace loomstone {

void write_checkpoint(const std::string& path, const Checkpoint& checkpoint);
Checkpoint read_checkpoint(const std::string& path);  // throws CacheError with the cause

}  // namespace loomstone
