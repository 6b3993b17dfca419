// Communicators of threads that act as ranks, with the mailboxes of ThreadMailboxes.
#pragma once

#include <barrier>
#include <cstring>
#include <memory>
#include <string>

#include "core/parallel/communicator.h"
#include "tests/parallel/threads_as_ranks.h"

namespace loomstone::testing {

class ThreadCommunicators {
 public:
  ThreadCommunicators(int size, double most_delay, unsigned seed)
      : mailboxes_(size, most_delay, seed),
        barrier_(size),
        given_(size),
        kinds_(size),
        texts_(size) {
    for (int rank = 0; rank < size; ++rank)
      ends_.push_back(std::make_shared<const End>(*this, rank));
  }
  std::shared_ptr<const Communicator> operator[](int rank) { return ends_[rank]; }

 private:
  // Mailbox that sends and receives through a mailbox that ThreadCommunicators owns.
  class Borrowed final : public Mailbox {
   public:
    explicit Borrowed(Mailbox& mailbox) : mailbox_(mailbox) {}
    int rank() const override { return mailbox_.rank(); }
    int size() const override { return mailbox_.size(); }
    void send(int to, const void* data, std::size_t bytes) override {
      mailbox_.send(to, data, bytes);
    }
    bool receive(std::vector<std::byte>& message) override { return mailbox_.receive(message); }

   private:
    Mailbox& mailbox_;
  };

  class End final : public Communicator {
   public:
    End(ThreadCommunicators& all, int rank) : all_(all), rank_(rank) {}
    int rank() const override { return rank_; }
    int size() const override { return static_cast<int>(all_.given_.size()); }
    void barrier() const override { all_.barrier_.arrive_and_wait(); }
    std::int64_t maximum(std::int64_t value) const override {
      std::vector<std::int64_t> values(size());
      values[rank_] = value;
      std::vector<std::size_t> offsets;
      for (int i = 0; i <= size(); ++i) offsets.push_back(i * sizeof value);
      gather_all(values.data(), offsets);
      return *std::max_element(values.begin(), values.end());
    }
    void broadcast(void* data, std::size_t bytes, int root) const override {
      all_.given_[rank_] = static_cast<std::byte*>(data);
      barrier();
      if (rank_ != root) std::memcpy(data, all_.given_[root], bytes);
      barrier();
    }
    void start_gather(void* data, const std::vector<std::size_t>& offsets) const override {
      auto* const own = static_cast<std::byte*>(data);
      all_.given_[rank_] = own;
      barrier();
      for (int other = 0; other < size(); ++other)
        if (other != rank_)
          std::memcpy(own + offsets[other], all_.given_[other] + offsets[other],
                      offsets[other + 1] - offsets[other]);
      barrier();
    }
    void start_exchange(const std::vector<Message>&, const std::vector<Message>&) const override {
      abort(1);
    }
    void start_add(BinnedSum*, int) const override { abort(1); }
    void finish() const override {}  // start_gather() completes the gather
    std::unique_ptr<Mailbox> open_mailbox() const override {
      return std::make_unique<Borrowed>(all_.mailboxes_[rank_]);
    }
    void agree(int& kind, std::string& text) const override {
      all_.kinds_[rank_] = kind, all_.texts_[rank_] = text;
      barrier();
      for (int other = size() - 1; other >= 0; --other)
        if (all_.kinds_[other] != 0) kind = all_.kinds_[other], text = all_.texts_[other];
      barrier();
    }
    void abort(int) const override { std::abort(); }

   private:
    ThreadCommunicators& all_;
    int rank_;
  };

  ThreadMailboxes mailboxes_;
  std::barrier<> barrier_;
  std::vector<std::byte*> given_;
  std::vector<int> kinds_;
  std::vector<std::string> texts_;
  std::vector<std::shared_ptr<const Communicator>> ends_;
};

}  // namespace loomstone::testing
