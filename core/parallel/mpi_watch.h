// Ends the job if a rank waits for the others longer than a time-out, because MPI detects neither a
// stopped process nor a cut link. This file belongs to the MPI plug-in.
#pragma once

#include <chrono>
#include <memory>
#include <string>

namespace loomstone {

// Exit code of a job that ends because a wait exceeds the time-out (EX_TEMPFAIL of sysexits.h).
inline constexpr int timeout_exit_code = 75;

// Time-out that the environment variable LOOMSTONE_MPI_TIMEOUT gives [s]; 0 if it is unset or
// empty, and negative if it is not a finite number >= 0.
double mpi_timeout();

// A thread that observes the waits of this rank and answers the watches of the other ranks. If a
// wait exceeds the time-out, the watch asks all ranks what they are doing. If the wait then still
// continues, the lowest rank that has waited longer than the time-out ends the job: it prints which
// ranks do not answer or do not communicate, with their hosts, and aborts all ranks. If it does not
// do so in time, another rank that has waited too long ends the job. Requires MPI_THREAD_MULTIPLE.
class MpiWatch {
 public:
  // Collective over the communicator with this Fortran handle. The watch communicates through a
  // duplicate of this communicator.
  MpiWatch(int fortran_handle, std::chrono::duration<double> timeout);
  ~MpiWatch();
  MpiWatch(const MpiWatch&) = delete;
  MpiWatch& operator=(const MpiWatch&) = delete;

  // An object that exists while this rank waits for other ranks in one operation.
  class Wait {
   public:
    explicit Wait(const MpiWatch* watch);  // null: no time-out
    ~Wait();
    Wait(const Wait&) = delete;
    Wait& operator=(const Wait&) = delete;

   private:
    const MpiWatch* watch_;
  };

 private:
  class Thread;
  std::unique_ptr<Thread> thread_;
};

// Collective. Returns the watch of a communicator, or null if the time-out is off. If the watch
// cannot be made, returns null and sets *problem to a message.
std::unique_ptr<MpiWatch> make_watch(int fortran_handle, const char** problem);

}  // namespace loomstone
