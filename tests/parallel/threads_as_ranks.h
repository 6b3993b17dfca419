// Mailboxes of threads that act as ranks. Messages are delayed by random times and arrive in a
// random order, as they may on a network.
#pragma once

#include <chrono>
#include <mutex>
#include <random>
#include <vector>

#include "core/parallel/mailbox.h"
#include "tests/support/lasting_threads.h"

namespace loomstone::testing {

class ThreadMailboxes {
 public:
  // Each message arrives after a random delay of at most `most_delay` [s].
  ThreadMailboxes(int size, double most_delay, unsigned seed) : boxes_(size) {
    for (int rank = 0; rank < size; ++rank) {
      boxes_[rank].random.seed(seed + rank);
      ends_.emplace_back(*this, rank, most_delay);
    }
  }
  Mailbox& operator[](int rank) { return ends_[rank]; }

 private:
  using Clock = std::chrono::steady_clock;
  struct Letter {
    Clock::time_point arrival;
    std::vector<std::byte> bytes;
  };
  struct Box {
    std::mutex mutex;
    std::mt19937 random;
    std::vector<Letter> letters;
  };
  class End final : public Mailbox {
   public:
    End(ThreadMailboxes& all, int rank, double most_delay)
        : all_(all), rank_(rank), most_delay_(most_delay) {}
    int rank() const override { return rank_; }
    int size() const override { return static_cast<int>(all_.boxes_.size()); }
    void send(int to, const void* data, std::size_t bytes) override {
      Box& box = all_.boxes_[to];
      const std::lock_guard lock(box.mutex);
      const auto* const first = static_cast<const std::byte*>(data);
      const std::chrono::duration<double> delay(
          std::uniform_real_distribution<double>(0.0, most_delay_)(box.random));
      box.letters.push_back({Clock::now() + std::chrono::duration_cast<Clock::duration>(delay),
                             {first, first + bytes}});
    }
    bool receive(std::vector<std::byte>& message) override {
      Box& box = all_.boxes_[rank_];
      const std::lock_guard lock(box.mutex);
      std::vector<std::size_t> arrived;
      const auto now = Clock::now();
      for (std::size_t i = 0; i < box.letters.size(); ++i)
        if (box.letters[i].arrival <= now) arrived.push_back(i);
      if (arrived.empty()) return false;
      Letter& letter = box.letters[arrived[box.random() % arrived.size()]];
      message = std::move(letter.bytes);
      std::swap(letter, box.letters.back());
      box.letters.pop_back();
      return true;
    }

   private:
    ThreadMailboxes& all_;
    int rank_;
    double most_delay_;
  };

  std::vector<Box> boxes_;
  std::vector<End> ends_;
};

// Calls body(rank) on `size` threads at the same time.
template <class Body>
void on_ranks(int size, Body&& body) {
  test::run_together(size, body);
}

}  // namespace loomstone::testing
