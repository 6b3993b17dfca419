#include <catch2/catch.hpp>

#include <cstdlib>
#include <string>

#include "core/base/error.h"
#include "core/parallel/communicator.h"

using namespace loomstone;
using Catch::Matchers::Contains;

namespace {

// Sets an environment variable, or removes it if `value` is null. The destructor restores it.
class Variable {
 public:
  Variable(const char* name, const char* value) : name_(name) {
    if (const char* old = std::getenv(name)) old_ = old, had_ = true;
    value ? setenv(name, value, 1) : unsetenv(name);
  }
  ~Variable() { had_ ? setenv(name_, old_.c_str(), 1) : unsetenv(name_); }

 private:
  const char* name_;
  std::string old_;
  bool had_ = false;
};

}  // namespace

TEST_CASE("without the plug-in several ranks are refused with the way to have it") {
  for (const char* path : {"/nonexistent/libloomstone_mpi.so", static_cast<const char*>(nullptr)}) {
    const Variable plugin("LOOMSTONE_MPI_PLUGIN", path);
    CHECK_THROWS_AS(mpi_communicator(), Unsupported);
    CHECK_THROWS_WITH(mpi_communicator(),
                      Contains("libloomstone_mpi.so") && Contains("libopenmpi-dev") &&
                          Contains("MPI is a plug-in of builds from the sources"));
  }
}

TEST_CASE("a file that is no plug-in is refused") {
  const Variable plugin("LOOMSTONE_MPI_PLUGIN", "/proc/self/environ");
  CHECK_THROWS_AS(mpi_communicator(), Unsupported);
  CHECK_THROWS_WITH(mpi_communicator(), Contains("could not be loaded"));
}

TEST_CASE("a launcher is recognised by more than one rank in the environment") {
  const Variable open_mpi("OMPI_COMM_WORLD_SIZE", nullptr), pmi("PMI_SIZE", nullptr),
      slurm("SLURM_STEP_NUM_TASKS", nullptr);
  CHECK_FALSE(launched_by_mpi());
  {
    const Variable four("SLURM_STEP_NUM_TASKS", "4");
    CHECK(launched_by_mpi());
  }
  {
    const Variable one("OMPI_COMM_WORLD_SIZE", "1");
    CHECK_FALSE(launched_by_mpi());
  }
  {
    const Variable two("OMPI_COMM_WORLD_SIZE", "2");
    CHECK(launched_by_mpi());
  }
  const Variable three("PMI_SIZE", "3");
  CHECK(launched_by_mpi());
}

TEST_CASE("a single rank communicates with nobody") {
  const auto communicator = single_communicator();
  CHECK(communicator->rank() == 0);
  CHECK(communicator->size() == 1);
  CHECK(communicator->maximum(-5) == -5);
  communicator->barrier();
}
