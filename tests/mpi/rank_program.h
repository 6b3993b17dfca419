// Shared parts of programs that run on several ranks: claims, which end all ranks if false, and
// hashes, which show whether results have the same bits on all ranks and in other runs.
#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>

#include "core/parallel/communicator.h"

namespace loomstone::testing {

class RankProgram {
 public:
  // Uses MPI if a launcher started several ranks, and otherwise a single rank without MPI. The
  // first argument of the program is the number of threads; the default is 1.
  RankProgram(int argc, char** argv)
      : communicator_(launched_by_mpi() ? mpi_communicator() : single_communicator()),
        threads_(argc > 1 ? std::atoi(argv[1]) : 1) {}

  const std::shared_ptr<const Communicator>& communicator() const { return communicator_; }
  int threads() const { return threads_; }

  // Ends all ranks if the claim is false.
  void claim(const char* sentence, bool holds) const {
    if (holds) return;
    std::fprintf(stderr, "rank %d: not true: %s\n", communicator_->rank(), sentence);
    communicator_->abort(1);
  }

  // Claims that the bytes have the same hash on all ranks, and prints the hash on rank 0.
  void print_hash(const char* what, const void* data, std::size_t bytes) const {
    std::uint64_t hash = 14695981039346656037u;  // FNV-1a
    for (std::size_t i = 0; i < bytes; ++i)
      hash = (hash ^ static_cast<const unsigned char*>(data)[i]) * 1099511628211u;
    const auto positive = static_cast<std::int64_t>(hash >> 1);
    claim(what, communicator_->maximum(positive) == positive &&
                    -communicator_->maximum(-positive) == positive);
    if (communicator_->rank() == 0)
      std::printf("%s %016llx\n", what, static_cast<unsigned long long>(hash));
  }

  // Runs the program; an exception on one rank ends all ranks.
  template <class Body>
  int run(Body&& body) const {
    try {
      body(*this);
      return 0;
    } catch (const std::exception& error) {
      std::fprintf(stderr, "rank %d: %s\n", communicator_->rank(), error.what());
      communicator_->abort(1);
      return 1;
    }
  }

 private:
  std::shared_ptr<const Communicator> communicator_;
  int threads_;
};

}  // namespace loomstone::testing
