// File name of the MPI plug-in, and name and type of the function that mpi_loader.cpp looks up.
#pragma once

#include "core/parallel/communicator.h"

extern "C" {
// Duplicates the MPI communicator with the given Fortran handle (-1: MPI_COMM_WORLD). Returns a new
// object, which the caller must delete. On failure, returns null and sets *problem to a message.
using LoomstoneMakeCommunicator = const loomstone::Communicator* (*)(int fortran_handle,
                                                                     const char** problem);
}

namespace loomstone {
inline constexpr const char* mpi_plugin_file = "libloomstone_mpi.so";
inline constexpr const char* mpi_plugin_symbol = "loomstone_make_communicator_6";
}  // namespace loomstone
