// Waiting of threads between two parallel loops, which the environment variables OMP_WAIT_POLICY
// and GOMP_SPINCOUNT control. The Python package sets GOMP_SPINCOUNT before it loads this code
// (loomstone/base/waiting.py).
#pragma once

namespace loomstone {

// True if waiting threads sleep at once (OMP_WAIT_POLICY=passive). A loop then takes about 40 us
// longer.
bool threads_sleep();

}  // namespace loomstone
