// What waiting threads do between two parallel loops.
#pragma once

namespace loomstone {

// Whether they sleep (OMP_WAIT_POLICY=passive): a loop then costs some 40 us more.
bool threads_sleep();

}  // namespace loomstone
