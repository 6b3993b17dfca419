#include "core/parallel/mpi_watch.h"

#include <mpi.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <condition_variable>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <list>
#include <mutex>
#include <thread>
#include <vector>

#include <unistd.h>

namespace loomstone {

namespace {

using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

constexpr int question_tag = 1, answer_tag = 2;
// Limits of patience_, the time for which a watch waits for missing answers to its roll call (see
// call_roll()). The watch waits twice as long if a lower rank has exceeded the time-out, too. Even
// if all ranks answer at once, the watch waits for shortest_patience before it ends the job. Both
// limits are our choice.
constexpr Seconds shortest_patience{1.0}, longest_patience{10.0};
constexpr Seconds longest_tick{0.05};
// MPI_Abort itself can hang: it may wait for an unreachable host or, in MPICH, for the thread that
// waits for other ranks. After this time [s], the process exits, and the launcher ends the other
// processes.
constexpr unsigned abort_seconds = 2;
constexpr int host_length = 64;

// Answer of a rank to a roll call.
struct Answer {
  int call;        // number of the roll call; late answers may arrive during the next one
  int waiting;     // 1 if the rank waits for other ranks, 0 if it computes
  double seconds;  // duration of this wait or computation [s]
};

std::int64_t ticks_now() { return Clock::now().time_since_epoch().count(); }

double seconds_since(std::int64_t ticks) {
  return Seconds(Clock::duration(ticks_now() - ticks)).count();
}

}  // namespace

double mpi_timeout() {
  const char* text = std::getenv("LOOMSTONE_MPI_TIMEOUT");
  if (text == nullptr || *text == '\0') return 0.0;
  char* end = nullptr;
  const double seconds = std::strtod(text, &end);
  return *end == '\0' && std::isfinite(seconds) && seconds >= 0.0 ? seconds : -1.0;
}

class MpiWatch::Thread {
 public:
  Thread(MPI_Comm original, Seconds timeout)
      : timeout_(timeout),
        patience_(std::clamp(0.5 * timeout, shortest_patience, longest_patience)),
        changed_(ticks_now()) {
    MPI_Comm_dup(original, &comm_);
    MPI_Comm_rank(comm_, &rank_);
    MPI_Comm_size(comm_, &size_);
    hosts_.resize(static_cast<std::size_t>(size_) * host_length);
    std::array<char, host_length> host{};
    gethostname(host.data(), host_length - 1);
    MPI_Allgather(host.data(), host_length, MPI_CHAR, hosts_.data(), host_length, MPI_CHAR, comm_);
    // MPI_Finalize first deletes the attributes of MPI_COMM_SELF. This deletion calls
    // stop_before_finalize(). No thread may call MPI once MPI is finalised.
    MPI_Comm_create_keyval(MPI_COMM_NULL_COPY_FN, stop_before_finalize, &key_, nullptr);
    MPI_Comm_set_attr(MPI_COMM_SELF, key_, this);
    thread_ = std::thread([this] { watch(); });
  }

  ~Thread() {
    if (!thread_.joinable()) return;  // MPI_Finalize has stopped the thread
    MPI_Comm_delete_attr(MPI_COMM_SELF, key_);
    MPI_Comm_free(&comm_);
  }
  Thread(const Thread&) = delete;
  Thread& operator=(const Thread&) = delete;

  void begin_wait() {
    changed_ = ticks_now();
    waiting_ = true;
  }
  void end_wait() {
    waiting_ = false;
    changed_ = ticks_now();
  }

 private:
  static int stop_before_finalize(MPI_Comm, int, void* self, void*) {
    static_cast<Thread*>(self)->stop();
    return MPI_SUCCESS;
  }

  void stop() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      stopped_ = true;
    }
    wake_.notify_all();
    if (thread_.joinable()) thread_.join();
  }

  // Waits for one tick. Returns false once the watch is stopped.
  bool pause() {
    std::unique_lock<std::mutex> lock(mutex_);
    wake_.wait_for(lock, std::min(longest_tick, 0.05 * timeout_), [this] { return stopped_; });
    return !stopped_;
  }

  void watch() {
    while (pause()) {
      answer_questions();
      if (overdue()) call_roll();
    }
  }

  bool overdue() const { return waiting_ && seconds_since(changed_) > timeout_.count(); }

  void answer_questions() {
    sent_.remove_if([](Sent& sent) {
      int done = 0;
      MPI_Test(&sent.request, &done, MPI_STATUS_IGNORE);
      return done != 0;
    });
    for (MPI_Status status; arrived(question_tag, status);) {
      Answer answer{0, waiting_ ? 1 : 0, seconds_since(changed_)};
      MPI_Recv(&answer.call, 1, MPI_INT, status.MPI_SOURCE, question_tag, comm_, &status);
      Sent& sent = sent_.emplace_back(Sent{answer, MPI_REQUEST_NULL});
      MPI_Isend(&sent.content, sizeof answer, MPI_BYTE, status.MPI_SOURCE, answer_tag, comm_,
                &sent.request);
    }
  }

  // Asks all other ranks what they are doing and collects their answers. Aborts all ranks if this
  // rank is then still in the same wait.
  void call_roll() {
    const std::int64_t since = changed_;
    const auto same_wait = [&] { return waiting_ && changed_ == since; };
    std::vector<Answer> answers(static_cast<std::size_t>(size_), Answer{-1, 0, 0.0});
    answers[static_cast<std::size_t>(rank_)] = {++call_, 1, seconds_since(since)};
    for (int other = 0; other < size_; ++other)
      if (other != rank_) ask(other);
    // Several ranks may exceed the time-out and call the roll at about the same time. The lowest of
    // them ends the job. The others end it only if the lowest rank has not done so after twice
    // `patience_`.
    for (const auto begin = Clock::now(); same_wait() && pause();) {
      answer_questions();
      collect(answers);
      const Seconds passed = Clock::now() - begin;
      const auto called = [&](const Answer& answer) { return answer.call == call_; };
      const bool complete = std::all_of(answers.begin(), answers.end(), called);
      const int speaker = speaker_of(answers);
      if (passed > patience_ * (speaker == rank_ ? 1.0 : 2.0)) break;
      if (complete && speaker == rank_ && passed > shortest_patience) break;
    }
    if (same_wait() && !is_stopped()) end_job(answers, seconds_since(since));
  }

  bool is_stopped() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return stopped_;
  }

  void collect(std::vector<Answer>& answers) {
    for (MPI_Status status; arrived(answer_tag, status);) {
      Answer answer{};
      MPI_Recv(&answer, sizeof answer, MPI_BYTE, status.MPI_SOURCE, answer_tag, comm_, &status);
      if (answer.call == call_) answers[static_cast<std::size_t>(status.MPI_SOURCE)] = answer;
    }
  }

  int speaker_of(const std::vector<Answer>& answers) const {
    for (int rank = 0; rank < rank_; ++rank) {
      const Answer& answer = answers[static_cast<std::size_t>(rank)];
      if (answer.call == call_ && answer.waiting != 0 && answer.seconds > timeout_.count())
        return rank;
    }
    return rank_;
  }

  [[noreturn]] void end_job(const std::vector<Answer>& answers, double waited) const {
    std::string said;
    for (int rank = 0; rank < size_; ++rank) {
      const Answer& answer = answers[static_cast<std::size_t>(rank)];
      if (answer.call == call_ && answer.waiting != 0) continue;
      if (!said.empty()) said += "; ";
      said += named(rank);
      said += answer.call != call_ ? " does not answer"
                                   : " has not communicated for " + in_seconds(answer.seconds);
    }
    if (said.empty()) said = "all ranks wait for one another";
    std::fprintf(stderr,
                 "loomstone: %s: %s has waited for %s, longer than LOOMSTONE_MPI_TIMEOUT=%g\n",
                 said.c_str(), named(rank_).c_str(), in_seconds(waited).c_str(), timeout_.count());
    std::fflush(stderr);
    std::signal(SIGALRM, [](int) { std::_Exit(timeout_exit_code); });
    alarm(abort_seconds);
    MPI_Abort(comm_, timeout_exit_code);
    std::_Exit(timeout_exit_code);
  }

  std::string named(int rank) const {
    return "rank " + std::to_string(rank) + " on " +
           &hosts_[static_cast<std::size_t>(rank) * host_length];
  }

  static std::string in_seconds(double seconds) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.1f s", seconds);
    return text.data();
  }

  bool arrived(int tag, MPI_Status& status) const {
    int flag = 0;
    MPI_Iprobe(MPI_ANY_SOURCE, tag, comm_, &flag, &status);
    return flag != 0;
  }

  // Asks a rank for its answer: sends it the number of the roll call. Does not wait until the
  // message is received, because the rank may be unreachable.
  void ask(int rank) {
    Sent& sent = sent_.emplace_back(Sent{Answer{call_, 0, 0.0}, MPI_REQUEST_NULL});
    MPI_Isend(&sent.content.call, 1, MPI_INT, rank, question_tag, comm_, &sent.request);
  }

  struct Sent {
    Answer content;
    MPI_Request request;
  };

  const Seconds timeout_, patience_;
  MPI_Comm comm_ = MPI_COMM_NULL;
  int rank_ = 0, size_ = 1, key_ = MPI_KEYVAL_INVALID, call_ = 0;
  std::vector<char> hosts_;  // host names, host_length bytes per rank, zero-terminated
  std::list<Sent> sent_;
  std::atomic<bool> waiting_{false};
  std::atomic<std::int64_t> changed_;  // latest start or end of a wait [ticks of Clock]
  std::mutex mutex_;
  std::condition_variable wake_;
  bool stopped_ = false;
  std::thread thread_;
};

MpiWatch::MpiWatch(int fortran_handle, Seconds timeout)
    : thread_(std::make_unique<Thread>(MPI_Comm_f2c(fortran_handle), timeout)) {}

MpiWatch::~MpiWatch() = default;

MpiWatch::Wait::Wait(const MpiWatch* watch) : watch_(watch) {
  if (watch_ != nullptr) watch_->thread_->begin_wait();
}

MpiWatch::Wait::~Wait() {
  if (watch_ != nullptr) watch_->thread_->end_wait();
}

std::unique_ptr<MpiWatch> make_watch(int fortran_handle, const char** problem) {
  const MPI_Comm comm = MPI_Comm_f2c(fortran_handle);
  int provided = MPI_THREAD_SINGLE;
  MPI_Query_thread(&provided);
  const double mine = mpi_timeout();
  std::array<double, 3> all = {mine, -mine, provided < MPI_THREAD_MULTIPLE ? 1.0 : 0.0};
  MPI_Allreduce(MPI_IN_PLACE, all.data(), all.size(), MPI_DOUBLE, MPI_MAX, comm);
  const double largest = all[0], least = -all[1];
  if (least < 0.0) {
    *problem = "LOOMSTONE_MPI_TIMEOUT must be a number of seconds >= 0; 0 or unset: no time-out";
  } else if (least != largest) {
    *problem =
        "LOOMSTONE_MPI_TIMEOUT must be the same on all ranks; forward it to other hosts (Open MPI: "
        "mpirun -x LOOMSTONE_MPI_TIMEOUT)";
  } else if (largest > 0.0 && all[2] != 0.0) {
    *problem = "LOOMSTONE_MPI_TIMEOUT needs MPI_THREAD_MULTIPLE; initialise MPI with it";
  } else if (largest > 0.0) {
    return std::make_unique<MpiWatch>(fortran_handle, Seconds(largest));
  }
  return nullptr;
}

}  // namespace loomstone
