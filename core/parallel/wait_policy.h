// How threads wait between two parallel loops: as OMP_WAIT_POLICY or GOMP_SPINCOUNT say. The
// Python package sets the latter before it loads this code (loomstone/base/waiting.py).
#pragma once

namespace loomstone {

// Whether they sleep at once (OMP_WAIT_POLICY=passive): a loop then costs some 40 us more.
bool threads_sleep();

}  // namespace loomstone
