// Reads and writes the looks (colours, roughness and textures) of surfaces in the files of a run.
#pragma once

#include <string>
#include <vector>

#include "core/base/look.h"
#include "core/cache/hdf5_file.h"

namespace loomstone {

// Writes the looks (core/base/look.h) of all surfaces of a file to the new group `group`. Writes
// nothing if `looks` is empty.
void write_looks(Hdf5File& file, const std::string& group, const std::vector<Look>& looks);
// Reads the looks of n surfaces. Returns an empty vector if the file has none. Throws CacheError if
// the file is damaged.
std::vector<Look> read_looks(const Hdf5File& file, const std::string& group, std::size_t n);

}  // namespace loomstone
