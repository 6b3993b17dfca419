// The directory from which this code was loaded. It also contains the MPI plug-in, and in wheels
// OSMesa, which are loaded at run time.
#pragma once

#include <filesystem>

namespace loomstone {

// Returns the directory of the module or program that contains this code; empty if it is unknown.
std::filesystem::path own_directory();

}  // namespace loomstone
