// The HDF5 file driver of loomstone's files. A flush changes the structure of a file as a whole: if
// the writer is killed during it, a reader with this driver finds the state before or after it.
#pragma once

#include <hdf5.h>

namespace loomstone::hdf5 {

// Returns the identifier of the driver, for H5Pset_driver(). Its files have the format of the
// default driver, H5FD_SEC2, which reads them if no writer was killed during a flush. Its handle is
// a POSIX file descriptor.
hid_t journal_driver();

}  // namespace loomstone::hdf5
