// The HDF5 file driver of loomstone's files. A flush changes the structure of a file atomically: if
// the writer is killed during a flush, a reader with this driver finds the state before or after
// that flush.
#pragma once

#include <hdf5.h>

namespace loomstone::hdf5 {

// Returns the identifier of the driver, for H5Pset_driver(), or a negative number if HDF5 refuses
// the driver. The files have the format of H5FD_SEC2, the default driver of HDF5. H5FD_SEC2 can
// read them if no writer was killed during a flush. In a file that is open for reading only,
// metadata that has been read once does not change, even if another process writes the file. If a
// file is opened twice, HDF5 treats it as two different files.
hid_t journal_driver();

// Returns whether a file still contains the metadata that has been read from it. If so, all of this
// metadata belongs to one state of the file. `file` must be open for reading only. Returns true for
// files of other drivers.
bool still_as_read(hid_t file);

// After this call, nothing is written to the open file, and reads return what would have been
// written. Does nothing to files of other drivers.
void discard_changes(hid_t file);

}  // namespace loomstone::hdf5
