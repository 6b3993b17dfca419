#include "core/parallel/task_pool.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstring>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "core/parallel/patience.h"
#include "core/parallel/termination.h"

namespace loomstone {

namespace {

using Clock = std::chrono::steady_clock;
using Tests = std::vector<NodeTest>;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// Number of tests between two readings of the clock. It is greater than 1, so that the readings
// take little time.
constexpr std::int64_t tests_per_look = 4;

// First bytes of every message. In a message of the kind Task, the tests of the task follow.
struct Header {
  PoolMessage kind;
  std::int32_t round;
  std::int32_t from, wave;
  // In messages of the kind Counts: numbers of tasks that the sender of the message and the ranks
  // below it in the tree (termination.h) have sent and received.
  std::int64_t sent, received;
};

// Tasks of one rank, and the number of its workers that perform tests.
class SharedTasks {
 public:
  Index size() const { return size_.load(std::memory_order_relaxed); }

  void put(Tests tests) {
    const std::lock_guard lock(mutex_);
    tasks_.push_back(std::move(tests));
    ++size_;
  }
  // Moves the newest task to the stack of a worker, which then counts as active. Returns false if
  // there is no task.
  bool start(Tests& stack) {
    const std::lock_guard lock(mutex_);
    if (tasks_.empty()) return false;
    stack = std::move(tasks_.back());
    tasks_.pop_back();
    --size_, ++active_;
    return true;
  }
  void stop() {
    const std::lock_guard lock(mutex_);
    --active_;
  }
  // Removes and returns the oldest task, for another rank; returns nothing if there is no task to
  // give. The tests of the oldest task are usually closest to the roots of the hierarchies. If no
  // worker is active, keeps one task, because ranks could otherwise pass a task on forever without
  // performing it.
  std::optional<Tests> give() {
    const std::lock_guard lock(mutex_);
    const std::size_t kept = active_ > 0 ? 0 : 1;
    if (tasks_.size() <= kept) return std::nullopt;
    Tests tests = std::move(tasks_.front());
    tasks_.pop_front();
    --size_;
    return tests;
  }
  // Returns whether some of the `threads` workers are idle and there is no task for them.
  bool hungry(int threads) const {
    const std::lock_guard lock(mutex_);
    return tasks_.empty() && active_ < threads;
  }
  // Returns whether this rank has no work at all.
  bool passive() const {
    const std::lock_guard lock(mutex_);
    return tasks_.empty() && active_ == 0;
  }

 private:
  mutable std::mutex mutex_;
  std::deque<Tests> tasks_;  // oldest first
  std::atomic<Index> size_{0};
  int active_ = 0;
};

// One run of the pool on one rank. Only worker 0 uses the mailbox.
class PoolRun {
 public:
  PoolRun(Mailbox& mailbox, const PoolOptions& options, std::int32_t round, const Team& team,
          const TaskPool::Perform& perform)
      : mailbox_(mailbox),
        options_(options),
        round_(round),
        team_(team),
        perform_(perform),
        termination_(mailbox.rank(), mailbox.size()),
        victim_(mailbox.rank()) {}

  void put(Tests tests) {
    if (!tests.empty()) tasks_.put(std::move(tests));
  }
  void work(int worker);
  void handle(const std::vector<std::byte>& message);
  // Messages of the next run that have already arrived.
  std::vector<std::vector<std::byte>>& early() { return early_; }
  const PoolReport& report() const { return report_; }
  void rethrow() const {
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  bool several() const { return mailbox_.size() > 1; }
  void perform_task(int worker, Tests& stack);
  void note_failure();
  void share(Tests& stack);
  bool poll();
  void set_idle(bool idle);
  void ask();
  void answer(int rank);
  void contribute();
  void end();
  void send(int to, PoolMessage kind, std::int64_t sent = 0, std::int64_t received = 0);

  Mailbox& mailbox_;
  const PoolOptions& options_;
  const std::int32_t round_;
  const Team& team_;
  const TaskPool::Perform& perform_;
  SharedTasks tasks_;
  Termination termination_;
  int victim_;            // rank that was asked last
  bool waiting_ = false;  // waits for the answer to a request
  bool idle_ = false;     // without work, and waiting for messages
  std::atomic<bool> ended_{false}, failed_{false};
  std::atomic<std::int64_t> tests_{0}, created_{0}, busy_{0};  // busy_: time spent on tasks [ns]
  Clock::time_point polled_;
  std::vector<std::byte> message_;  // scratch
  std::vector<std::vector<std::byte>> early_;
  PoolReport report_;
  std::mutex failing_;
  std::exception_ptr failure_;  // first exception on this rank
};

void PoolRun::work(int worker) {
  const auto start = Clock::now();
  if (worker == 0) polled_ = start;
  Tests stack;
  Patience patience;
  while (!ended_.load(std::memory_order_relaxed)) {
    if (tasks_.start(stack)) {
      perform_task(worker, stack);
      tasks_.stop();
      patience.reset();
      continue;
    }
    if (worker == 0) {
      const bool arrived = poll();
      contribute();
      if (arrived) {
        patience.reset();
        continue;
      }
      set_idle(!ended_ && tasks_.passive());
    }
    patience.wait();
  }
  if (worker != 0) return;
  set_idle(false);
  report_.tests = tests_, report_.created = created_;
  report_.busy = 1e-9 * static_cast<double>(busy_);
  report_.waves = termination_.wave() + 1;
  report_.wall = seconds_since(start);
}

void PoolRun::perform_task(int worker, Tests& stack) {
  const BusyTimer timer(team_);
  const auto start = Clock::now();
  std::int64_t n = 0;
  while (!stack.empty()) {
    const NodeTest test = stack.back();
    stack.pop_back();
    ++n;
    try {
      if (!failed_.load(std::memory_order_relaxed)) perform_(worker, test, stack);
    } catch (...) {
      note_failure();
    }
    if (failed_.load(std::memory_order_relaxed)) stack.clear();
    share(stack);
    const bool looks_at_clock = worker == 0 && several() && n % tests_per_look == 0;
    if (looks_at_clock && seconds_since(polled_) > options_.poll_interval) poll();
  }
  tests_ += n;
  busy_ += std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now() - start).count();
}

// Stores the current exception if it is the first one on this rank. From then on, the workers of
// this rank discard their tests.
void PoolRun::note_failure() {
  const std::lock_guard lock(failing_);
  if (!failure_) failure_ = std::current_exception();
  failed_ = true;
}

// Turns tests at the bottom of the stack into tasks while the stack exceeds the threshold. Does
// nothing if there is only one thread on one rank.
void PoolRun::share(Tests& stack) {
  if (!several() && team_.threads <= 1) return;
  for (Index most = stack_threshold(options_, tasks_.size());
       static_cast<Index>(stack.size()) > most; most = stack_threshold(options_, tasks_.size())) {
    const auto end = stack.begin() + most / 2;
    tasks_.put({stack.begin(), end});
    stack.erase(stack.begin(), end);
    ++created_;
  }
}

// Handles all messages that have arrived. Then asks for a task if a worker is idle, the pool is
// empty and no earlier request is unanswered. Returns whether any message has arrived.
bool PoolRun::poll() {
  bool any = false;
  while (mailbox_.receive(message_)) {
    any = true;
    handle(message_);
  }
  ask();
  polled_ = Clock::now();
  return any;
}

// Tells the mailbox that this rank begins or stops waiting.
void PoolRun::set_idle(bool idle) {
  if (idle == idle_) return;
  idle_ = idle;
  if (idle)
    mailbox_.begin_wait();
  else
    mailbox_.end_wait();
}

void PoolRun::handle(const std::vector<std::byte>& message) {
  Header header;
  std::memcpy(&header, message.data(), sizeof header);
  if (header.round > round_) {
    early_.push_back(message);
    return;
  }
  // Requests and refusals may still be on their way when a run ends. The next run ignores them.
  if (header.round < round_) return;
  switch (header.kind) {
    case PoolMessage::Request:
      answer(header.from);
      break;
    case PoolMessage::Refusal:
      waiting_ = false;
      break;
    case PoolMessage::Task: {
      Tests tests((message.size() - sizeof header) / sizeof(NodeTest));
      std::memcpy(tests.data(), message.data() + sizeof header, tests.size() * sizeof(NodeTest));
      ++report_.received;
      waiting_ = false;
      set_idle(false);
      tasks_.put(std::move(tests));
      break;
    }
    case PoolMessage::Wave:
      termination_.begin(header.wave);
      for (int child = termination_.first_child(); child < termination_.last_child(); ++child)
        send(child, PoolMessage::Wave);
      break;
    case PoolMessage::Counts:
      termination_.add(header.sent, header.received);
      break;
    case PoolMessage::End:
      end();
  }
}

void PoolRun::ask() {
  if (waiting_ || !several() || ended_ || !tasks_.hungry(team_.threads)) return;
  victim_ = (victim_ + 1) % mailbox_.size();
  if (victim_ == mailbox_.rank()) victim_ = (victim_ + 1) % mailbox_.size();
  waiting_ = true;
  ++report_.requests;
  send(victim_, PoolMessage::Request);
}

void PoolRun::answer(int rank) {
  const std::optional<Tests> tests = tasks_.give();
  if (!tests) {
    ++report_.refusals;
    send(rank, PoolMessage::Refusal);
    return;
  }
  ++report_.transfers;
  const Header header{PoolMessage::Task, round_, mailbox_.rank(), 0, 0, 0};
  std::vector<std::byte> message(sizeof header + tests->size() * sizeof(NodeTest));
  std::memcpy(message.data(), &header, sizeof header);
  std::memcpy(message.data() + sizeof header, tests->data(), tests->size() * sizeof(NodeTest));
  mailbox_.send(rank, message.data(), message.size());
}

// Contributes to the current wave if this rank has no work and the counts of its children have
// arrived. Rank 0 then ends the run or starts the next wave.
void PoolRun::contribute() {
  if (!termination_.ready() || ended_ || !tasks_.passive()) return;
  termination_.contribute(report_.transfers, report_.received);
  if (mailbox_.rank() != 0) {
    send(termination_.parent(), PoolMessage::Counts, termination_.sent(), termination_.received());
  } else if (termination_.done()) {
    end();
  } else {
    termination_.begin(termination_.wave() + 1);
    for (int child = termination_.first_child(); child < termination_.last_child(); ++child)
      send(child, PoolMessage::Wave);
  }
}

void PoolRun::end() {
  for (int child = termination_.first_child(); child < termination_.last_child(); ++child)
    send(child, PoolMessage::End);
  ended_ = true;
}

void PoolRun::send(int to, PoolMessage kind, std::int64_t sent, std::int64_t received) {
  const Header header{kind, round_, mailbox_.rank(), termination_.wave(), sent, received};
  mailbox_.send(to, &header, sizeof header);
}

}  // namespace

TaskPool::TaskPool(Mailbox& mailbox, const PoolOptions& options)
    : mailbox_(mailbox), options_(options) {}

PoolReport TaskPool::run(const Team& team, std::vector<NodeTest> tests, const Perform& perform) {
  PoolRun run(mailbox_, options_, ++round_, team, perform);
  run.put(std::move(tests));
  for (const std::vector<std::byte>& message : std::exchange(early_, {})) run.handle(message);
  on_each_thread(team, [&](int worker) { run.work(worker); });
  early_ = std::move(run.early());
  run.rethrow();
  if (team.iterations) *team.iterations += run.report().tests;
  return run.report();
}

}  // namespace loomstone
