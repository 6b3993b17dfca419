// Ranks that are threads of one process, for tests of work that is divided among ranks.
#pragma once

#include <algorithm>
#include <barrier>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/parallel/communicator.h"
#include "tests/support/lasting_threads.h"

namespace loomstone::test {

// Data that the ranks of one communicator share.
struct ThreadHub {
  explicit ThreadHub(int n)
      : size(n), barrier(n), data(n), values(n), messages(n), kinds(n), texts(n) {}

  int size;
  std::barrier<> barrier;
  std::vector<void*> data;
  std::vector<std::int64_t> values;
  std::vector<const std::vector<Communicator::Message>*> messages;
  std::vector<int> kinds;
  std::vector<std::string> texts;
};

class ThreadRank final : public Communicator {
 public:
  ThreadRank(int rank, ThreadHub& hub) : rank_(rank), hub_(hub) {}

  int rank() const override { return rank_; }
  int size() const override { return hub_.size; }
  void barrier() const override { hub_.barrier.arrive_and_wait(); }
  std::int64_t maximum(std::int64_t value) const override {
    hub_.values[rank_] = value;
    barrier();
    for (const std::int64_t other : hub_.values) value = std::max(value, other);
    barrier();
    return value;
  }
  void broadcast(void* data, std::size_t bytes, int root) const override {
    hub_.data[rank_] = data;
    barrier();
    if (rank_ != root && bytes > 0) std::memcpy(data, hub_.data[root], bytes);
    barrier();
  }
  void start_gather(void* data, const std::vector<std::size_t>& byte_offsets) const override {
    ++n_gathers_;
    hub_.data[rank_] = data;
    barrier();
    for (int other = 0; other < size(); ++other) {
      const std::size_t begin = byte_offsets[other], n = byte_offsets[other + 1] - begin;
      if (other == rank_ || n == 0) continue;
      std::memcpy(static_cast<char*>(data) + begin,
                  static_cast<const char*>(hub_.data[other]) + begin, n);
    }
    barrier();
  }
  void start_exchange(const std::vector<Message>& to,
                      const std::vector<Message>& from) const override {
    hub_.messages[rank_] = &to;
    barrier();
    for (const Message& wanted : from)
      for (const Message& sent : *hub_.messages[wanted.rank])
        if (sent.rank == rank_ && sent.bytes > 0) std::memcpy(wanted.data, sent.data, sent.bytes);
    barrier();
  }
  void start_add(BinnedSum* sums, int n) const override {
    std::vector<BinnedSum> own(sums, sums + n);
    hub_.data[rank_] = own.data();
    barrier();
    for (int other = 0; other < size(); ++other)
      for (int i = 0; i < n && other != rank_; ++i)
        sums[i].add(static_cast<const BinnedSum*>(hub_.data[other])[i]);
    barrier();
  }
  void finish() const override {}  // the functions start_... complete their operations
  void agree(int& kind, std::string& text) const override {
    hub_.kinds[rank_] = kind;
    hub_.texts[rank_] = text;
    barrier();
    for (int other = size() - 1; other >= 0; --other)
      if (hub_.kinds[other] != 0) kind = hub_.kinds[other], text = hub_.texts[other];
    barrier();
  }
  // Counts only gathers.
  Traffic traffic() const override { return {.operations = n_gathers_}; }
  [[noreturn]] void abort(int) const override { std::abort(); }

 private:
  int rank_;
  ThreadHub& hub_;
  mutable std::int64_t n_gathers_ = 0;
};

// Calls work(communicator) on n ranks, each in its own thread, and waits for all of them. Rethrows
// the exception of the lowest rank that throws. If a rank throws in `work`, the other ranks must
// not wait for it at a barrier, because they would wait forever. Catch2 must not be used in `work`,
// because it is not thread-safe.
inline void on_ranks(int n,
                     const std::function<void(const std::shared_ptr<const Communicator>&)>& work) {
  ThreadHub hub(n);
  std::vector<std::exception_ptr> failures(n);
  run_together(n, [&](int rank) {
    try {
      work(std::make_shared<const ThreadRank>(rank, hub));
    } catch (...) {
      failures[rank] = std::current_exception();
    }
  });
  for (const std::exception_ptr& failure : failures)
    if (failure) std::rethrow_exception(failure);
}

}  // namespace loomstone::test
