#include "core/parallel/wait_policy.h"

#include <cstdlib>

#include <strings.h>

namespace loomstone {

bool threads_sleep() {
  static const bool sleep = [] {
    // libgomp reads this variable once, when the library is loaded.
    const char* policy = std::getenv("OMP_WAIT_POLICY");
    return policy && strcasecmp(policy, "passive") == 0;
  }();
  return sleep;
}

}  // namespace loomstone
