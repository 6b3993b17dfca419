// The environment variables OMP_WAIT_POLICY and GOMP_SPINCOUNT determine how threads wait between
// two parallel loops. Unless one of them is set or libgomp is already loaded, the Python package
// sets GOMP_SPINCOUNT while it loads this code (loomstone/base/waiting.py).
#pragma once

namespace loomstone {

// Returns whether OMP_WAIT_POLICY is passive. Unless GOMP_SPINCOUNT is set, waiting threads then
// sleep at once, and each parallel loop takes tens of microseconds longer.
bool threads_sleep();

}  // namespace loomstone
