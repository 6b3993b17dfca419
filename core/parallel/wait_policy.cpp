#include "core/parallel/wait_policy.h"

#include <cstdlib>

#include <strings.h>

namespace loomstone {

bool threads_sleep() {
  static const bool sleep = [] {
    const char* policy = std::getenv("OMP_WAIT_POLICY");  // libgomp reads it when it is loaded
    return policy && strcasecmp(policy, "passive") == 0;
  }();
  return sleep;
}

}  // namespace loomstone
