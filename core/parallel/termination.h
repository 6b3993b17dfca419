// Termination detection of the task pools: the four-counter method [Mattern1987]. Waves sum the
// numbers of tasks sent and received, along a tree of ranks. A rank contributes to a wave only
// while it has no work. All work is done if one wave counts as many sent tasks as the preceding
// wave counted received tasks. Messages may arrive late and in any order.
#pragma once

#include <algorithm>
#include <cstdint>

namespace loomstone {

// State of the termination detection on one rank. Waves are numbered from 0. In every wave, counts
// pass from all ranks to rank 0. Rank 0 then starts the next wave, or ends the run.
class Termination {
 public:
  Termination(int rank, int size) : rank_(rank), size_(size) { begin(0); }

  std::int32_t wave() const { return wave_; }
  void begin(std::int32_t wave) {
    wave_ = wave;
    missing_ = last_child() - first_child();
    sent_ = received_ = 0;
    contributed_ = false;
  }
  // Adds the sums over a child and the ranks below it.
  void add(std::int64_t sent, std::int64_t received) {
    sent_ += sent, received_ += received;
    --missing_;
  }
  // Returns whether this rank may contribute to the wave as soon as it has no work.
  bool ready() const { return missing_ == 0 && !contributed_; }
  void contribute(std::int64_t sent, std::int64_t received) {
    sent_ += sent, received_ += received;
    contributed_ = true;
  }
  // Must be called once per wave, on rank 0 after its contribution. Returns whether all work is
  // done.
  bool done() {
    const bool done = size_ == 1 || received_before_ == sent_;
    received_before_ = received_;
    return done;
  }
  // Sums over this rank and the ranks below it, for its parent.
  std::int64_t sent() const { return sent_; }
  std::int64_t received() const { return received_; }

  int parent() const { return (rank_ - 1) / most_children; }
  int first_child() const { return std::min(size_, most_children * rank_ + 1); }
  int last_child() const { return std::min(size_, most_children * (rank_ + 1) + 1); }

 private:
  static constexpr int most_children = 16;  // largest number of children of a rank in the tree

  int rank_, size_;
  std::int32_t wave_ = 0;
  int missing_ = 0;  // children whose counts have not arrived
  bool contributed_ = false;
  std::int64_t sent_ = 0, received_ = 0;
  std::int64_t received_before_ = -1;  // rank 0: received tasks that the preceding wave counted
};

}  // namespace loomstone
