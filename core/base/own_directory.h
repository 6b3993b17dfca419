// The directory from which this code was loaded. Libraries in it are loaded at run time: the MPI
// plug-in in builds with MPI, and OSMesa in wheels.
#pragma once

#include <filesystem>

namespace loomstone {

// Returns the directory of the module or program that contains this code; empty if it is unknown.
std::filesystem::path own_directory();

}  // namespace loomstone
