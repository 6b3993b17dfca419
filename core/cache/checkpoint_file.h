// A checkpoint: named arrays and texts that hold a State exactly. Written under another name and
// renamed.
#pragma once

#include <string>

#include "core/base/checkpoint.h"

namespace loomstone {

void write_checkpoint(const std::string& path, const Checkpoint& checkpoint);
Checkpoint read_checkpoint(const std::string& path);  // throws CacheError naming what is wrong

}  // namespace loomstone
