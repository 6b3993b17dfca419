// The ranks of one simulation. One rank needs no MPI; more come from a plug-in that is loaded only
// when asked for. All calls are collective.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/base/types.h"

namespace loomstone {

class Communicator {
 public:
  virtual ~Communicator() = default;
  virtual int rank() const = 0;
  virtual int size() const = 0;
  virtual void barrier() const = 0;
  // Largest value over all ranks (errors and signals are agreed with this).
  virtual std::int64_t maximum(std::int64_t value) const = 0;
  // Bytes of `root` to all.
  virtual void broadcast(void* data, std::size_t bytes, int root) const = 0;
  // Every rank contributes bytes [offsets[rank], offsets[rank+1]) of `data`; afterwards all hold
  // all of it.
  virtual void gather_all(void* data, const std::vector<std::size_t>& byte_offsets) const = 0;
  // Sends byte buffers to the ranks of `to` and receives buffers (sized by the caller) from the
  // ranks of `from`.
  struct Message {
    int rank;
    void* data;
    std::size_t bytes;
  };
  virtual void exchange(const std::vector<Message>& to, const std::vector<Message>& from) const = 0;
  // Failures, on a channel of their own, since they strike while others may wait in any call above.
  // Gives kind (0: none) and text of the lowest rank that failed to all. Where this rank failed and
  // the others do not come here within ten seconds, it ends them all: they wait for it elsewhere.
  // One rank: leaves both as they are.
  virtual void agree(int& kind, std::string& text) const {
    static_cast<void>(kind), static_cast<void>(text);
  }
  // The last failure that ranks agreed on; empty on one rank.
  virtual std::string agreed() const { return {}; }
  // Ends all ranks at once, for an error that only one of them met (else the others would wait for
  // ever).
  [[noreturn]] virtual void abort(int code) const = 0;
};

// One rank, no MPI.
std::shared_ptr<const Communicator> single_communicator();

// Loads the MPI plug-in and duplicates the given communicator (Fortran handle, as mpi4py's
// comm.py2f() gives; -1: MPI_COMM_WORLD). Initialises MPI if nobody has. Throws Unsupported, naming
// the package, where MPI is missing.
std::shared_ptr<const Communicator> mpi_communicator(int fortran_handle = -1);

// True where this process was started by an MPI launcher with more than one rank (read from the
// environment).
bool launched_by_mpi();

}  // namespace loomstone
