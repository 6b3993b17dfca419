// The environment variables OMP_WAIT_POLICY and GOMP_SPINCOUNT determine how threads wait between
// two parallel loops. If neither is set and libgomp is not loaded yet, the Python package sets
// GOMP_SPINCOUNT while it loads this code (loomstone/base/waiting.py).
#pragma once

namespace loomstone {

// Returns whether OMP_WAIT_POLICY is passive. If so, and if GOMP_SPINCOUNT is not set, waiting
// threads sleep at once, and each parallel loop takes tens of microseconds longer.
bool threads_sleep();

}  // namespace loomstone
