// Communication between the ranks of one simulation. A single rank needs no MPI. Several ranks use
// the MPI plug-in, which is loaded on demand. All communication is collective, except exchange(),
// start_exchange(), abort() and the messages of a Mailbox.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/types.h"
#include "core/parallel/binned_sum.h"
#include "core/parallel/mailbox.h"

namespace loomstone {

// Communication of a rank since its communicator was made.
struct Traffic {
  double waiting = 0.0;    // time spent waiting for other ranks [s]
  std::int64_t bytes = 0;  // data that this rank sent or contributed [bytes]
  // Number of exchanges and of collective operations, without calls of open_mailbox().
  std::int64_t operations = 0;
};

class Communicator {
 public:
  virtual ~Communicator() = default;
  virtual int rank() const = 0;
  virtual int size() const = 0;
  virtual void barrier() const = 0;
  // Returns the largest value over all ranks.
  virtual std::int64_t maximum(std::int64_t value) const = 0;
  // Copies the data of rank `root` to all ranks.
  virtual void broadcast(void* data, std::size_t bytes, int root) const = 0;
  // A buffer that is sent to or received from a rank.
  struct Message {
    int rank;
    void* data;
    std::size_t bytes;
  };

  // The next three functions start operations, and finish() completes all of them. Until then, the
  // data must stay in place and must not be used. Several operations can be incomplete at a time,
  // but at most one of them may be a gather.

  // Every rank contributes the bytes [byte_offsets[rank], byte_offsets[rank + 1]) of `data` and
  // receives all other bytes.
  virtual void start_gather(void* data, const std::vector<std::size_t>& byte_offsets) const = 0;
  // Sends the buffers in `to` and receives data into the buffers in `from`. The caller sets the
  // sizes of all buffers, including those in `from`.
  virtual void start_exchange(const std::vector<Message>& to,
                              const std::vector<Message>& from) const = 0;
  // Replaces each of the n sums by its sum over all ranks.
  virtual void start_add(BinnedSum* sums, int n) const = 0;
  // Completes all operations that have been started.
  virtual void finish() const = 0;

  void gather_all(void* data, const std::vector<std::size_t>& byte_offsets) const {
    start_gather(data, byte_offsets);
    finish();
  }
  void exchange(const std::vector<Message>& to, const std::vector<Message>& from) const {
    start_exchange(to, from);
    finish();
  }
  void add(BinnedSum* sums, int n) const {
    start_add(sums, n);
    finish();
  }

  // Collective. Returns a new mailbox, whose messages are separate from those of all other
  // mailboxes. All ranks must destroy the mailbox together, and the communicator must outlive it.
  virtual std::unique_ptr<Mailbox> open_mailbox() const {
    throw Unsupported("this communicator has no mailboxes; use that of MPI or of a single rank");
  }
  // Lets all ranks agree on a failure. The agreement uses a separate channel, because other ranks
  // may be waiting in another call. All ranks receive the kind (0: no failure) and the text of the
  // failure on the lowest rank that failed. If the other ranks do not call agree() within ten
  // seconds, a failed rank aborts all ranks. On a single rank, both arguments are left unchanged.
  virtual void agree(int& kind, std::string& text) const {
    static_cast<void>(kind), static_cast<void>(text);
  }
  // Returns the text of the latest failure on which the ranks agreed. It is empty if there has been
  // none, and always without MPI.
  virtual std::string agreed() const { return {}; }
  // Traffic of this rank; zero without MPI.
  virtual Traffic traffic() const { return {}; }
  // Returns whether some host has more ranks than processors on which they may run.
  virtual bool shares_processors() const { return false; }
  // Ends all ranks at once after an error on only one of them, because the other ranks could wait
  // forever.
  [[noreturn]] virtual void abort(int code) const = 0;
};

// Communicator of a single rank, without MPI.
std::shared_ptr<const Communicator> single_communicator();

// Loads the MPI plug-in and duplicates a communicator. The communicator is given by its Fortran
// handle, such as mpi4py's comm.py2f(). -1 denotes MPI_COMM_WORLD; MPI is then initialised if
// necessary. Throws Unsupported with advice if the plug-in cannot be loaded, and InvalidInput if
// the plug-in cannot make a communicator or if the launcher belongs to another MPI library. If
// LOOMSTONE_MPI_TIMEOUT [s] is set and not 0, a rank that waits for the other ranks longer than
// this time ends all ranks (mpi_watch.h).
std::shared_ptr<const Communicator> mpi_communicator(int fortran_handle = -1);

// Returns true if an MPI launcher started this process with more than one rank, according to the
// environment.
bool launched_by_mpi();

}  // namespace loomstone
