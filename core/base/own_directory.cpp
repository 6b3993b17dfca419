#include "core/base/own_directory.h"

#include <system_error>

#include <dlfcn.h>

namespace loomstone {

std::filesystem::path own_directory() {
  Dl_info info{};
  if (dladdr(reinterpret_cast<const void*>(&own_directory), &info) == 0 ||
      info.dli_fname == nullptr)
    return {};
  std::filesystem::path file = info.dli_fname;
  if (!file.has_parent_path())
    // For a program found on PATH, dladdr gives only the bare name.
    file = "/proc/self/exe";
  std::error_code ignored;
  return std::filesystem::canonical(file, ignored).parent_path();
}

}  // namespace loomstone
