// Short messages between ranks. The sender does not wait for the receiver, which polls for
// messages. Messages between two ranks may arrive in any order.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

namespace loomstone {

class Mailbox {
 public:
  virtual ~Mailbox() = default;
  virtual int rank() const = 0;
  virtual int size() const = 0;
  // Sends a copy of the bytes and returns without waiting for the receiver.
  virtual void send(int to, const void* data, std::size_t bytes) = 0;
  // If a message has arrived, copies it to `message` and returns true; otherwise returns false.
  virtual bool receive(std::vector<std::byte>& message) = 0;
  // begin_wait() must be called when this rank begins to wait for messages, and end_wait() when it
  // stops waiting. The time between these calls counts as Traffic::waiting and towards the time-out
  // of mpi_watch.h.
  virtual void begin_wait() {}
  virtual void end_wait() {}
};

}  // namespace loomstone
