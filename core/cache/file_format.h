// Versions of the layout of a file. Each file contains its version. If this build cannot read that
// version, the error message tells the user what to do.
#pragma once

#include <cstdint>
#include <string>

#include "core/base/message.h"

namespace loomstone {

struct FileFormat {
  const char* what;             // kind of file in messages: "file" or "checkpoint"
  std::int64_t oldest, newest;  // versions that this build reads; it writes `newest`
  const char* instead;          // advice for older files
};

// Throws CacheError unless this build can read files of version `found`.
inline void check_file_format(const std::string& path, const FileFormat& format,
                              std::int64_t found) {
  if (found > format.newest)
    fail<CacheError>(
        "{}: was written by a newer version ({} format {}, this build reads up to {}); update "
        "loomstone.",
        path, format.what, found, format.newest);
  const std::string read = format.oldest == format.newest
                               ? formatted("{}", format.newest)
                               : formatted("{} to {}", format.oldest, format.newest);
  if (found < format.oldest)
    fail<CacheError>("{}: was written by an older version ({} format {}, this build reads {}); {}.",
                     path, format.what, found, read, format.instead);
}

}  // namespace loomstone
