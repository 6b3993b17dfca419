// The directory from which this code was loaded. Libraries that are loaded on request lie there.
#pragma once

#include <filesystem>

namespace loomstone {

// Returns the directory of the module or program that contains this code; empty if it is unknown.
std::filesystem::path own_directory();

}  // namespace loomstone
