// Binds the communicators of a single rank and of MPI ranks. Also binds functions that return
// whether an MPI launcher started this process as one of several ranks, the number of available
// processors, and the number of threads in OMP_NUM_THREADS. The plug-in for MPI is loaded when it
// is first needed.
#include "core/parallel/communicator.h"

#include "bindings/bindings.h"
#include "core/base/message.h"
#include "core/parallel/shared_work.h"
#include "core/parallel/team.h"

namespace loomstone {

Team team_of(int threads) {
  if (threads < 0) fail<InvalidInput>("threads must be at least 0, got {}", threads);
  return Team{threads == 0 ? default_thread_count() : threads};
}

void bind_parallel(py::module_& m) {
  py::classh<Communicator> c(m, "Communicator", "The ranks of one simulation.");
  c.def_property_readonly("rank", &Communicator::rank, "index of this rank, from 0");
  c.def_property_readonly("size", &Communicator::size, "number of ranks");
  c.def("barrier", &Communicator::barrier, py::call_guard<py::gil_scoped_release>(),
        "Waits until all ranks have reached this call.");
  c.def("maximum", &Communicator::maximum, py::arg("value"),
        py::call_guard<py::gil_scoped_release>(), "Largest value over all ranks.");
  c.def(
      "agree",
      [](const Communicator& self, int kind, std::string text) {
        const py::gil_scoped_release release;
        self.agree(kind, text);
        return std::pair(kind, text);
      },
      py::arg("kind"), py::arg("text"),
      "Returns the kind (0: none) and text of the failure of the lowest rank that has failed, the "
      "same on all ranks. If this\n"
      "rank has failed and the others do not make this call within ten seconds, all ranks are "
      "terminated.");
  c.def(
      "gather",
      [](const Communicator& self, const std::string& text) {
        const py::gil_scoped_release release;
        const Gathered<char> all =
            gather_from_ranks(self, [&] { return std::vector<char>(text.begin(), text.end()); });
        std::vector<std::string> texts;
        for (int rank = 0; rank < self.size(); ++rank)
          texts.emplace_back(all.elements.data() + all.start[rank],
                             all.start[rank + 1] - all.start[rank]);
        return texts;
      },
      py::arg("text"), "Returns the texts of all ranks, in the order of the ranks, on every rank.");
  c.def_property_readonly("agreed", &Communicator::agreed,
                          "Text of the last failure that the ranks agreed on.");
  c.def("abort", &Communicator::abort, py::arg("code"), "Terminates all ranks immediately.");
  c.def("__repr__", [](const Communicator& self) {
    return formatted("Communicator(rank {} of {})", self.rank(), self.size());
  });
  m.def(
      "single_communicator",
      [] { return std::const_pointer_cast<Communicator>(single_communicator()); },
      "Communicator of a single rank, without MPI.");
  m.def(
      "mpi_communicator",
      [](int handle) { return std::const_pointer_cast<Communicator>(mpi_communicator(handle)); },
      py::arg("fortran_handle") = -1,
      "Communicator for the ranks of an MPI communicator, given by its Fortran handle (in mpi4py: "
      "comm.py2f()). -1: all ranks.");
  m.def("launched_by_mpi", &launched_by_mpi,
        "True if an MPI launcher started this process as one of several ranks.");
  m.def("available_processors", &available_processors,
        "Number of processors that this process may use.");
  m.def("threads_in_environment", &threads_in_environment,
        "Number of threads in OMP_NUM_THREADS (the first number of a list); 0 if it is unset or "
        "invalid.");
}

}  // namespace loomstone
