// Finds and loads the MPI plug-in. The environment variable LOOMSTONE_MPI_PLUGIN gives its path,
// for example in tests of the build tree. If the variable is unset or empty, the plug-in is
// expected in the directory of the module or program that contains this code, as in the Python
// package.
#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>

#include <dlfcn.h>

#include "core/base/message.h"
#include "core/base/own_directory.h"
#include "core/parallel/mpi_plugin.h"
#include "core/parallel/patience.h"

namespace loomstone {

namespace {

namespace fs = std::filesystem;

fs::path plugin_path() {
  const char* named = std::getenv("LOOMSTONE_MPI_PLUGIN");
  return named != nullptr && *named != '\0' ? fs::path(named) : own_directory() / mpi_plugin_file;
}

LoomstoneMakeCommunicator load_plugin() {
  const fs::path path = plugin_path();
  constexpr const char* advice =
      "MPI is a plug-in of builds from the sources, not of wheels: install MPI (Debian: apt-get "
      "install libopenmpi-dev openmpi-bin) and build loomstone, or run on one rank";
  std::error_code ignored;
  if (!fs::exists(path, ignored))
    fail<Unsupported>("several ranks need the MPI plug-in, which is not at {}; {}", path.string(),
                      advice);
  // RTLD_GLOBAL is needed because components of Open MPI look up symbols of libmpi.
  void* plugin = dlopen(path.c_str(), RTLD_NOW | RTLD_GLOBAL);
  if (plugin == nullptr)
    fail<Unsupported>("several ranks need the MPI plug-in, which could not be loaded ({}); {}",
                      dlerror(), advice);
  void* make = dlsym(plugin, mpi_plugin_symbol);
  if (make == nullptr)
    fail<Unsupported>(
        "the MPI plug-in must belong to this version of loomstone, got another at {}; rebuild both "
        "together",
        path.string());
  return reinterpret_cast<LoomstoneMakeCommunicator>(make);
}

int integer_of(const char* variable) {
  const char* text = std::getenv(variable);
  return text == nullptr ? 0 : std::atoi(text);
}

int launched_ranks() {
  // Open MPI sets the first of these variables, MPICH and Intel MPI the second, and srun the third.
  // In a batch script, outside srun, the third one is not set.
  for (const char* variable : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "SLURM_STEP_NUM_TASKS"})
    if (const int n = integer_of(variable); n > 0) return n;
  return 1;
}

}  // namespace

std::shared_ptr<const Communicator> mpi_communicator(int fortran_handle) {
  const char* problem = "the MPI plug-in created no communicator and gave no reason";
  std::shared_ptr<const Communicator> made(load_plugin()(fortran_handle, &problem));
  if (made == nullptr) throw InvalidInput(problem);
  if (fortran_handle == -1 && made->size() == 1 && launched_by_mpi())
    fail<InvalidInput>(
        "the launcher must belong to the MPI library of loomstone, got {} processes that each run "
        "alone; use its mpirun, or srun --mpi=pmix",
        launched_ranks());
  if (made->shares_processors()) share_processors();
  return made;
}

bool launched_by_mpi() { return launched_ranks() > 1; }

}  // namespace loomstone
