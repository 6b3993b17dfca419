#include "core/parallel/pool_replay.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <limits>
#include <numeric>
#include <queue>
#include <utility>

#include "core/parallel/termination.h"

namespace loomstone {

namespace {

constexpr double never = std::numeric_limits<double>::infinity();

// Size of the header of a message [bytes].
constexpr double header_bytes = 32.0;

// Returns the duration [s] of an exchange in which each rank receives `bytes` bytes in total. The
// number of rounds of messages is the logarithm of the number of ranks to base 2, rounded up. On a
// single rank, the duration is 0.
double exchange_seconds(int n_ranks, double bytes, const Network& network) {
  if (n_ranks == 1) return 0.0;
  return std::ceil(std::log2(n_ranks)) * (network.latency + 2.0 * network.overhead) +
         bytes / network.bandwidth;
}

// Adds the duration of the final exchange, in which all ranks receive all results, to the total
// time of the report. Also sets ReplayReport::exchange to this duration.
void add_exchange(int n_ranks, std::size_t result_bytes, const Network& network,
                  ReplayReport& report) {
  report.exchange = exchange_seconds(n_ranks, static_cast<double>(result_bytes), network);
  report.seconds += report.exchange;
}

void set_busy(const std::vector<double>& busy, ReplayReport& report) {
  report.least_busy = *std::min_element(busy.begin(), busy.end());
  report.most_busy = *std::max_element(busy.begin(), busy.end());
  report.mean_busy =
      std::accumulate(busy.begin(), busy.end(), 0.0) / static_cast<double>(busy.size());
}

using TestNumbers = std::vector<Index>;

struct Message {
  double arrival;
  PoolMessage kind;
  int from;
  std::int32_t wave = 0;
  std::int64_t sent = 0, received = 0;
  TestNumbers tests = {};
};

// State of a simulated rank. Simulated ranks follow the rules of TaskPool.
struct Rank {
  Rank(int rank, int size) : termination(rank, size), victim(rank) {}

  bool passive() const { return stack.empty() && pool.empty(); }

  Termination termination;
  TestNumbers stack;
  std::deque<TestNumbers> pool;  // oldest task first
  std::vector<Message> inbox;
  double next = never;  // time of the next event of this rank [s]
  double free = 0.0;    // time until which this rank works or handles messages [s]
  double busy = 0.0, end = never;
  int victim;
  bool waiting = false;
  std::int64_t sent = 0, received = 0;
};

class Simulated {
 public:
  Simulated(const RecordedTests& tests, const Network& network, const PoolOptions& options)
      : tests_(tests), network_(network), options_(options) {
    for (int rank = 0; rank < tests.n_ranks(); ++rank) {
      Rank& own = ranks_.emplace_back(rank, tests.n_ranks());
      own.stack = tests.roots[rank];
      own.free = tests.start[rank];
      schedule(rank, tests.start[rank]);
    }
  }

  ReplayReport run() {
    while (!events_.empty()) {
      const auto [time, rank] = events_.top();
      events_.pop();
      if (ranks_[rank].next == time) act(rank, time);
    }
    std::vector<double> busy;
    for (const Rank& rank : ranks_) {
      report_.seconds = std::max(report_.seconds, rank.end);
      busy.push_back(rank.busy);
    }
    set_busy(busy, report_);
    add_exchange(tests_.n_ranks(), tests_.result_bytes, network_, report_);
    const double deal = tests_.deal_exchanges * exchange_seconds(tests_.n_ranks(), 0.0, network_) +
                        (tests_.n_ranks() > 1 ? tests_.deal_bytes / network_.bandwidth : 0.0);
    report_.exchange += deal, report_.seconds += deal;
    return report_;
  }

 private:
  void schedule(int rank, double time) {
    ranks_[rank].next = time;
    if (time < never) events_.emplace(time, rank);
  }

  // A rank polls, and then works until it polls again. Without work, it contributes to the
  // termination detection and waits for a message.
  void act(int rank, double time) {
    Rank& own = ranks_[rank];
    own.next = never;
    time = poll(rank, time);
    if (own.end < never) return;
    if (!own.passive()) {
      own.free = work(own, time);
      schedule(rank, own.free);
      return;
    }
    own.free = time = contribute(rank, time);
    if (own.end < never) return;
    double next = never;
    for (const Message& message : own.inbox) next = std::min(next, message.arrival);
    schedule(rank, std::max(time, next));
  }

  double work(Rank& own, double time) {
    const double start = time;
    while (!own.passive() && time - start < options_.poll_interval) {
      if (own.stack.empty()) {
        own.stack = std::move(own.pool.back());
        own.pool.pop_back();
      }
      const Index test = own.stack.back();
      own.stack.pop_back();
      for (Index i = 0; i < tests_.n_children[test]; ++i)
        own.stack.push_back(tests_.first_child[test] + i);
      time += tests_.seconds[test];
      share(own);
    }
    own.busy += time - start;
    return time;
  }

  void share(Rank& own) const {
    if (ranks_.size() == 1) return;
    const auto threshold = [&] {
      return stack_threshold(options_, static_cast<Index>(own.pool.size()));
    };
    for (Index most = threshold(); static_cast<Index>(own.stack.size()) > most;
         most = threshold()) {
      const auto end = own.stack.begin() + most / 2;
      own.pool.emplace_back(own.stack.begin(), end);
      own.stack.erase(own.stack.begin(), end);
    }
  }

  // Handles the messages that have arrived, and asks for work if this rank has none. Returns the
  // time afterwards.
  double poll(int rank, double time) {
    Rank& own = ranks_[rank];
    if (ranks_.size() > 1) time += network_.overhead;
    std::vector<Message> arrived;
    const auto late = std::partition(own.inbox.begin(), own.inbox.end(),
                                     [&](const Message& m) { return m.arrival > time; });
    std::move(late, own.inbox.end(), std::back_inserter(arrived));
    own.inbox.erase(late, own.inbox.end());
    std::sort(arrived.begin(), arrived.end(), [](const Message& a, const Message& b) {
      return std::pair(a.arrival, a.from) < std::pair(b.arrival, b.from);
    });
    for (Message& message : arrived) {
      time += network_.overhead;
      time = handle(rank, std::move(message), time);
    }
    return own.end < never || ranks_.size() == 1 ? time : ask(rank, time);
  }

  double handle(int rank, Message message, double time) {
    Rank& own = ranks_[rank];
    switch (message.kind) {
      case PoolMessage::Request:
        return answer(rank, message.from, time);
      case PoolMessage::Refusal:
        own.waiting = false;
        return time;
      case PoolMessage::Task:
        own.waiting = false;
        ++own.received;
        own.pool.push_back(std::move(message.tests));
        return time;
      case PoolMessage::Wave:
        own.termination.begin(message.wave);
        return tell_children(rank, PoolMessage::Wave, time);
      case PoolMessage::Counts:
        own.termination.add(message.sent, message.received);
        return time;
      case PoolMessage::End:
        break;
    }
    return finish(rank, time);
  }

  double ask(int rank, double time) {
    Rank& own = ranks_[rank];
    if (own.waiting || !own.passive()) return time;
    const int size = static_cast<int>(ranks_.size());
    own.victim = (own.victim + 1) % size;
    if (own.victim == rank) own.victim = (own.victim + 1) % size;
    own.waiting = true;
    ++report_.requests;
    return send(own.victim, {0.0, PoolMessage::Request, rank}, time);
  }

  double answer(int rank, int to, double time) {
    Rank& own = ranks_[rank];
    const std::size_t kept = own.stack.empty() ? 1 : 0;  // a rank without a test keeps one task
    if (own.pool.size() <= kept) {
      ++report_.refusals;
      return send(to, {0.0, PoolMessage::Refusal, rank}, time);
    }
    Message message{0.0, PoolMessage::Task, rank};
    message.tests = std::move(own.pool.front());
    own.pool.pop_front();
    ++own.sent, ++report_.transfers;
    return send(to, std::move(message), time);
  }

  double contribute(int rank, double time) {
    Rank& own = ranks_[rank];
    Termination& termination = own.termination;
    if (!termination.ready()) return time;
    termination.contribute(own.sent, own.received);
    if (rank != 0)
      return send(termination.parent(),
                  {0.0, PoolMessage::Counts, rank, termination.wave(), termination.sent(),
                   termination.received()},
                  time);
    ++report_.waves;
    if (termination.done()) return finish(rank, time);
    termination.begin(termination.wave() + 1);
    return tell_children(rank, PoolMessage::Wave, time);
  }

  double finish(int rank, double time) {
    time = tell_children(rank, PoolMessage::End, time);
    ranks_[rank].end = time;
    return time;
  }

  double tell_children(int rank, PoolMessage kind, double time) {
    const Termination& termination = ranks_[rank].termination;
    for (int child = termination.first_child(); child < termination.last_child(); ++child)
      time = send(child, {0.0, kind, rank, termination.wave()}, time);
    return time;
  }

  // Sends a message at `time`, and returns the time at which the sender is free again. The message
  // is dropped if the receiver has ended.
  double send(int to, Message message, double time) {
    time += network_.overhead;
    const double bytes =
        header_bytes + static_cast<double>(message.tests.size() * sizeof(NodeTest));
    message.arrival = time + network_.latency + bytes / network_.bandwidth;
    Rank& receiver = ranks_[to];
    if (receiver.end < never) return time;
    // A busy rank receives messages at its next poll, when its current work ends. A message wakes a
    // waiting rank.
    const double wake = std::max(message.arrival, receiver.free);
    receiver.inbox.push_back(std::move(message));
    if (wake < receiver.next) schedule(to, wake);
    return time;
  }

  using Event = std::pair<double, int>;
  const RecordedTests& tests_;
  const Network network_;
  const PoolOptions options_;
  std::vector<Rank> ranks_;
  std::priority_queue<Event, std::vector<Event>, std::greater<>> events_;
  ReplayReport report_;
};

}  // namespace

double RecordedTests::work() const { return std::accumulate(seconds.begin(), seconds.end(), 0.0); }

double OrderedWork::work() const {
  return std::accumulate(seconds.begin(), seconds.end(), divisible);
}

double clock_seconds() {
  using Clock = std::chrono::steady_clock;
  double least = never;
  for (int i = 0; i < 1000; ++i) {
    const auto start = Clock::now();
    least = std::min(least, std::chrono::duration<double>(Clock::now() - start).count());
  }
  return least;
}

ReplayReport replay_static(const RecordedTests& tests, const Network& network) {
  std::vector<double> busy;
  ReplayReport report;
  for (int rank = 0; rank < tests.n_ranks(); ++rank) {
    TestNumbers stack = tests.roots[rank];
    double seconds = 0.0;
    while (!stack.empty()) {
      const Index test = stack.back();
      stack.pop_back();
      seconds += tests.seconds[test];
      for (Index i = 0; i < tests.n_children[test]; ++i)
        stack.push_back(tests.first_child[test] + i);
    }
    busy.push_back(seconds);
    report.seconds = std::max(report.seconds, tests.start[rank] + seconds);
  }
  set_busy(busy, report);
  add_exchange(tests.n_ranks(), tests.result_bytes, network, report);
  return report;
}

ReplayReport replay_predicted(const OrderedWork& work, int n_ranks, const Network& network) {
  std::vector<double> busy(n_ranks, work.divisible / n_ranks);
  for (const std::vector<std::size_t>& starts :
       section_ranges(work.expected, work.first, n_ranks)) {
    const auto at = [&](int range) {
      return work.seconds.begin() + static_cast<std::ptrdiff_t>(starts[range]);
    };
    for (int rank = 0; rank < n_ranks; ++rank)
      busy[rank] = std::accumulate(at(rank), at(rank + 1), busy[rank]);
  }
  ReplayReport report;
  set_busy(busy, report);
  report.seconds = report.most_busy;
  add_exchange(n_ranks, work.result_bytes, network, report);
  return report;
}

ReplayReport replay_dynamic(const RecordedTests& tests, const Network& network,
                            const PoolOptions& options) {
  return Simulated(tests, network, options).run();
}

}  // namespace loomstone
