// Communicator based on MPI. Only this file and mpi_watch.cpp include mpi.h; they are built as a
// separate plug-in.
#include <mpi.h>

#include <algorithm>
#include <chrono>
#include <climits>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include <sched.h>

#include "core/parallel/mpi_plugin.h"
#include "core/parallel/mpi_watch.h"
#include "core/parallel/patience.h"

namespace loomstone {

namespace {

constexpr int exchange_tag = 4711;
// Longest time for which a failed rank waits in agree() for the other ranks to call agree().
constexpr std::chrono::seconds grace{10};
// Largest size of a message [bytes]. It is limited because MPI counts are ints. Broadcasts, gathers
// and exchanges send larger data in parts. Messages of a mailbox and sums are far smaller.
constexpr std::size_t largest_message = std::size_t{1} << 30;

void wait_for(MPI_Request& request) {
  Patience patience;
  for (int done = 0; MPI_Test(&request, &done, MPI_STATUS_IGNORE) == MPI_SUCCESS && !done;)
    patience.wait();
}

void wait_for(std::vector<MPI_Request>& requests) {
  Patience patience;
  for (int done = 0; MPI_Testall(static_cast<int>(requests.size()), requests.data(), &done,
                                 MPI_STATUSES_IGNORE) == MPI_SUCCESS &&
                     !done;)
    patience.wait();
}

// Marks the time between its construction and destruction as waiting for other ranks, and adds
// this time to the traffic of this rank.
class Waiting {
 public:
  Waiting(const MpiWatch* watch, Traffic& traffic)
      : wait_(watch), traffic_(traffic), start_(std::chrono::steady_clock::now()) {}
  ~Waiting() {
    const auto end = std::chrono::steady_clock::now();
    traffic_.waiting += std::chrono::duration<double>(end - start_).count();
  }
  Waiting(const Waiting&) = delete;
  Waiting& operator=(const Waiting&) = delete;

 private:
  const MpiWatch::Wait wait_;
  Traffic& traffic_;
  const std::chrono::steady_clock::time_point start_;
};

// MPI operation that adds the sums in `from` to those in `to`.
void add_sums(void* from, void* to, int* n, MPI_Datatype*) {
  for (int i = 0; i < *n; ++i)
    static_cast<BinnedSum*>(to)[i].add(static_cast<const BinnedSum*>(from)[i]);
}

bool finalised() {
  int flag = 0;
  MPI_Finalized(&flag);
  return flag != 0;
}

void finalise_at_exit() {
  if (!finalised()) MPI_Finalize();
}

// Mailbox that uses its own duplicate of a communicator.
class MpiMailbox final : public Mailbox {
 public:
  // `watch` observes waits and may be null.
  MpiMailbox(MPI_Comm original, const MpiWatch* watch, Traffic& traffic)
      : watch_(watch), traffic_(traffic) {
    MPI_Comm_dup(original, &comm_);
    MPI_Comm_rank(comm_, &rank_);
    MPI_Comm_size(comm_, &size_);
  }
  ~MpiMailbox() override {
    if (finalised()) return;
    // The last messages through a mailbox may remain unread, but they are short. MPI sends short
    // messages eagerly, so sending them completes without a receiver.
    for (Sent& sent : sent_) wait_for(sent.request);
    MPI_Comm_free(&comm_);
  }
  MpiMailbox(const MpiMailbox&) = delete;
  MpiMailbox& operator=(const MpiMailbox&) = delete;

  int rank() const override { return rank_; }
  int size() const override { return size_; }
  void send(int to, const void* data, std::size_t bytes) override {
    forget_completed();
    traffic_.bytes += static_cast<std::int64_t>(bytes);
    const auto* const first = static_cast<const std::byte*>(data);
    Sent& sent = sent_.emplace_back();
    sent.bytes.assign(first, first + bytes);
    MPI_Isend(sent.bytes.data(), static_cast<int>(bytes), MPI_BYTE, to, exchange_tag, comm_,
              &sent.request);
  }
  bool receive(std::vector<std::byte>& message) override {
    int arrived = 0, bytes = 0;
    MPI_Message handle;
    MPI_Status status;
    MPI_Improbe(MPI_ANY_SOURCE, exchange_tag, comm_, &arrived, &handle, &status);
    if (!arrived) return false;
    MPI_Get_count(&status, MPI_BYTE, &bytes);
    message.resize(bytes);
    MPI_Mrecv(message.data(), bytes, MPI_BYTE, &handle, MPI_STATUS_IGNORE);
    return true;
  }
  void begin_wait() override { waiting_.emplace(watch_, traffic_); }
  void end_wait() override { waiting_.reset(); }

 private:
  struct Sent {
    MPI_Request request = MPI_REQUEST_NULL;
    std::vector<std::byte> bytes;
  };

  void forget_completed() {
    for (int done = 1; !sent_.empty();) {
      MPI_Test(&sent_.front().request, &done, MPI_STATUS_IGNORE);
      if (!done) return;
      sent_.pop_front();
    }
  }

  MPI_Comm comm_ = MPI_COMM_NULL;
  int rank_ = 0, size_ = 1;
  const MpiWatch* watch_;
  Traffic& traffic_;
  std::optional<Waiting> waiting_;
  std::deque<Sent> sent_;  // messages whose sending may be incomplete, oldest first
};

// Collective. Returns whether some host has more ranks than processors on which they may run.
bool ranks_share_processors(MPI_Comm comm) {
  MPI_Comm host = MPI_COMM_NULL;
  MPI_Comm_split_type(comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &host);
  int ranks = 1;
  MPI_Comm_size(host, &ranks);
  cpu_set_t processors;
  CPU_ZERO(&processors);
  sched_getaffinity(0, sizeof processors, &processors);
  MPI_Allreduce(MPI_IN_PLACE, &processors, sizeof processors, MPI_BYTE, MPI_BOR, host);
  MPI_Comm_free(&host);
  int shares = ranks > CPU_COUNT(&processors) ? 1 : 0;
  MPI_Allreduce(MPI_IN_PLACE, &shares, 1, MPI_INT, MPI_MAX, comm);
  return shares != 0;
}

class MpiCommunicator final : public Communicator {
 public:
  // `watch` observes waits and may be null.
  MpiCommunicator(MPI_Comm original, std::unique_ptr<MpiWatch> watch)
      : watch_(std::move(watch)), shares_processors_(ranks_share_processors(original)) {
    MPI_Comm_dup(original, &comm_);
    MPI_Comm_dup(original, &failures_);
    MPI_Comm_rank(comm_, &rank_);
    MPI_Comm_size(comm_, &size_);
    MPI_Type_contiguous(sizeof(BinnedSum), MPI_BYTE, &sum_type_);
    MPI_Type_commit(&sum_type_);
    MPI_Op_create(add_sums, 1, &add_sums_);  // 1: commutative
  }
  ~MpiCommunicator() override {
    if (finalised()) return;
    MPI_Op_free(&add_sums_);
    MPI_Type_free(&sum_type_);
    MPI_Comm_free(&comm_);
    MPI_Comm_free(&failures_);
  }
  MpiCommunicator(const MpiCommunicator&) = delete;
  MpiCommunicator& operator=(const MpiCommunicator&) = delete;

  int rank() const override { return rank_; }
  int size() const override { return size_; }
  void barrier() const override {
    count(0);
    const Waiting waiting(watch_.get(), traffic_);
    MPI_Request request;
    MPI_Ibarrier(comm_, &request);
    wait_for(request);
  }

  std::int64_t maximum(std::int64_t value) const override {
    count(sizeof value);
    const Waiting waiting(watch_.get(), traffic_);
    std::int64_t largest = value;
    MPI_Request request;
    MPI_Iallreduce(&value, &largest, 1, MPI_INT64_T, MPI_MAX, comm_, &request);
    wait_for(request);
    return largest;
  }

  void broadcast(void* data, std::size_t bytes, int root) const override {
    count(root == rank_ ? bytes : 0);
    const Waiting waiting(watch_.get(), traffic_);
    send_from(root, data, bytes);
  }

  void start_gather(void* data, const std::vector<std::size_t>& byte_offsets) const override {
    count(byte_offsets[rank_ + 1] - byte_offsets[rank_]);
    if (byte_offsets.back() > largest_message) {
      const Waiting waiting(watch_.get(), traffic_);
      for (int root = 0; root < size_; ++root)
        send_from(root, static_cast<char*>(data) + byte_offsets[root],
                  byte_offsets[root + 1] - byte_offsets[root]);
      return;
    }
    counts_.resize(size_);
    displacements_.resize(size_);
    for (int other = 0; other < size_; ++other) {
      displacements_[other] = static_cast<int>(byte_offsets[other]);
      counts_[other] = static_cast<int>(byte_offsets[other + 1] - byte_offsets[other]);
    }
    MPI_Iallgatherv(MPI_IN_PLACE, 0, MPI_BYTE, data, counts_.data(), displacements_.data(),
                    MPI_BYTE, comm_, &requests_.emplace_back());
  }

  void start_exchange(const std::vector<Message>& to,
                      const std::vector<Message>& from) const override {
    std::size_t bytes = 0;
    for (const Message& message : to) bytes += message.bytes;
    count(bytes);
    for (const Message& message : from)
      in_parts(message, [&](void* data, int bytes) {
        MPI_Irecv(data, bytes, MPI_BYTE, message.rank, exchange_tag, comm_,
                  &requests_.emplace_back());
      });
    for (const Message& message : to)
      in_parts(message, [&](void* data, int bytes) {
        MPI_Isend(data, bytes, MPI_BYTE, message.rank, exchange_tag, comm_,
                  &requests_.emplace_back());
      });
  }

  void start_add(BinnedSum* sums, int n) const override {
    count(static_cast<std::size_t>(n) * sizeof(BinnedSum));
    MPI_Iallreduce(MPI_IN_PLACE, sums, n, sum_type_, add_sums_, comm_, &requests_.emplace_back());
  }

  void finish() const override {
    const Waiting waiting(watch_.get(), traffic_);
    wait_for(requests_);
    requests_.clear();
  }

  std::unique_ptr<Mailbox> open_mailbox() const override {
    return std::make_unique<MpiMailbox>(comm_, watch_.get(), traffic_);
  }

  void agree(int& kind, std::string& text) const override {
    count(sizeof(std::int64_t));
    const Waiting waiting(watch_.get(), traffic_);
    const std::int64_t mine = kind == 0 ? 0 : size_ - rank_;
    std::int64_t lowest = 0;
    MPI_Request request;
    MPI_Iallreduce(&mine, &lowest, 1, MPI_INT64_T, MPI_MAX, failures_, &request);
    if (kind == 0) {
      wait_for(request);
    } else if (!completes(request)) {
      std::fprintf(stderr, "rank %d: %s\n", rank_, text.c_str());
      abort(1);
    }
    if (lowest == 0) return;
    const int root = size_ - static_cast<int>(lowest);
    int shape[2] = {kind, static_cast<int>(text.size())};
    MPI_Ibcast(shape, 2, MPI_INT, root, failures_, &request);
    wait_for(request);
    kind = shape[0];
    text.resize(shape[1]);
    MPI_Ibcast(text.data(), shape[1], MPI_BYTE, root, failures_, &request);
    wait_for(request);
    agreed_ = text;
  }

  std::string agreed() const override { return agreed_; }
  Traffic traffic() const override { return traffic_; }
  bool shares_processors() const override { return shares_processors_; }

  void abort(int code) const override {
    MPI_Abort(comm_, code);
    std::_Exit(code);
  }

 private:
  static bool completes(MPI_Request& request) {
    const auto end = std::chrono::steady_clock::now() + grace;
    for (int done = 0; MPI_Test(&request, &done, MPI_STATUS_IGNORE) == MPI_SUCCESS && !done;) {
      if (std::chrono::steady_clock::now() > end) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return true;
  }

  // Counts an operation to which this rank contributes `bytes` bytes.
  void count(std::size_t bytes) const {
    traffic_.bytes += static_cast<std::int64_t>(bytes);
    ++traffic_.operations;
  }

  // Copies the data of rank `root` to all ranks.
  void send_from(int root, void* data, std::size_t bytes) const {
    char* next = static_cast<char*>(data);
    while (bytes > 0) {
      const std::size_t part = std::min(bytes, largest_message);
      MPI_Request request;
      MPI_Ibcast(next, static_cast<int>(part), MPI_BYTE, root, comm_, &request);
      wait_for(request);
      next += part;
      bytes -= part;
    }
  }

  template <class Send>
  static void in_parts(const Message& message, Send&& send) {
    char* next = static_cast<char*>(message.data);
    for (std::size_t left = message.bytes; left > 0;) {
      const std::size_t part = std::min(left, largest_message);
      send(next, static_cast<int>(part));
      next += part;
      left -= part;
    }
  }

  MPI_Comm comm_ = MPI_COMM_NULL, failures_ = MPI_COMM_NULL;
  MPI_Datatype sum_type_ = MPI_DATATYPE_NULL;
  MPI_Op add_sums_ = MPI_OP_NULL;
  int rank_ = 0, size_ = 1;
  std::unique_ptr<MpiWatch> watch_;
  bool shares_processors_;
  mutable std::vector<int> counts_, displacements_;  // arguments of the gather in progress
  mutable std::vector<MPI_Request> requests_;        // operations that are not complete
  mutable std::string agreed_;
  mutable Traffic traffic_;
};

}  // namespace

}  // namespace loomstone

extern "C" const loomstone::Communicator* loomstone_make_communicator_6(int fortran_handle,
                                                                        const char** problem) {
  using namespace loomstone;
  if (polling_time() < WaitTime{0.0}) {
    *problem = "LOOMSTONE_MPI_SPIN must be a number of microseconds >= 0; unset: 100";
    return nullptr;
  }
  int initialised = 0;
  MPI_Initialized(&initialised);
  if (finalised()) {
    *problem =
        "MPI must not be finalised before a simulation starts; create the simulation earlier";
    return nullptr;
  }
  if (!initialised) {
    if (fortran_handle != -1) {
      *problem =
          "a communicator was given but MPI is not initialised; initialise it first (import "
          "mpi4py.MPI)";
      return nullptr;
    }
    // Only the thread that steps the simulation and the thread of MpiWatch call MPI.
    const int needed = mpi_timeout() > 0.0 ? MPI_THREAD_MULTIPLE : MPI_THREAD_FUNNELED;
    int provided = MPI_THREAD_SINGLE;
    MPI_Init_thread(nullptr, nullptr, needed, &provided);
    std::atexit(finalise_at_exit);
  }
  int provided = MPI_THREAD_SINGLE;
  MPI_Query_thread(&provided);
  if (provided < MPI_THREAD_FUNNELED) {
    *problem =
        "MPI must be initialised for threads (MPI_THREAD_FUNNELED at least), got MPI_THREAD_SINGLE";
    return nullptr;
  }
  const MPI_Comm original = fortran_handle == -1 ? MPI_COMM_WORLD : MPI_Comm_f2c(fortran_handle);
  if (original == MPI_COMM_NULL || original == MPI_Comm{}) {
    *problem = "the communicator must be a valid MPI communicator; pass mpi4py's comm.py2f()";
    return nullptr;
  }
  const char* refused = nullptr;
  std::unique_ptr<MpiWatch> watch = make_watch(MPI_Comm_c2f(original), &refused);
  if (refused != nullptr) {
    *problem = refused;
    return nullptr;
  }
  auto made = std::make_unique<MpiCommunicator>(original, std::move(watch));
  if (made->shares_processors()) share_processors();
  return made.release();
}
