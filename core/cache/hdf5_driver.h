// The HDF5 file driver of loomstone's files. A flush changes the structure of a file as a whole: if
// the writer is killed during it, a reader with this driver finds the state before or after it.
#pragma once

#include <hdf5.h>

namespace loomstone::hdf5 {

// Returns the identifier of the driver, for H5Pset_driver(), or a negative number if HDF5 refuses
// it. Its files have the format of the default driver, H5FD_SEC2, which reads them if no writer was
// killed during a flush. In a file that is open for reading only, metadata that has been read once
// does not change, even if the file is written. If a file is opened twice, HDF5 keeps two states.
hid_t journal_driver();

// Returns whether the metadata that has been read from a file is still that of the file. If so, all
// of it belongs to one state of the file. `file` must be open for reading only. Returns true for
// files of other drivers.
bool still_as_read(hid_t file);

// From now on, nothing is written to an open file of this driver, and reads return what would have
// been written. Does nothing to files of other drivers.
void discard_changes(hid_t file);

}  // namespace loomstone::hdf5
