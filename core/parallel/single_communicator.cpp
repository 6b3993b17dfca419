// Communicator of a single rank, without MPI.
#include <cassert>
#include <cstdlib>

#include "core/parallel/communicator.h"

namespace loomstone {

namespace {

class SingleMailbox final : public Mailbox {
 public:
  int rank() const override { return 0; }
  int size() const override { return 1; }
  void send(int, const void*, std::size_t) override {
    assert(false && "a single rank has no other rank to send to");
  }
  bool receive(std::vector<std::byte>&) override { return false; }
};

class SingleCommunicator final : public Communicator {
 public:
  int rank() const override { return 0; }
  int size() const override { return 1; }
  void barrier() const override {}
  std::int64_t maximum(std::int64_t value) const override { return value; }
  void broadcast(void*, std::size_t, int) const override {}
  void start_gather(void*, const std::vector<std::size_t>&) const override {}
  void start_exchange(const std::vector<Message>& to,
                      const std::vector<Message>& from) const override {
    assert(to.empty() && from.empty() &&
           "a single rank has no other rank to exchange messages with");
    static_cast<void>(to), static_cast<void>(from);
  }
  void start_add(BinnedSum*, int) const override {}
  void finish() const override {}
  std::unique_ptr<Mailbox> open_mailbox() const override {
    return std::make_unique<SingleMailbox>();
  }
  void abort(int code) const override { std::_Exit(code); }
};

}  // namespace

std::shared_ptr<const Communicator> single_communicator() {
  static const auto only = std::make_shared<const SingleCommunicator>();
  return only;
}

}  // namespace loomstone
