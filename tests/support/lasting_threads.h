// Threads that last until the program ends, for tests in which threads act as ranks. The libomp of
// LLVM 14, which tests under the thread sanitizer use, crashes in __kmpc_free and
// __kmpc_end_critical, because it accesses memory of ended threads that had used OpenMP.
#pragma once

#include <omp.h>

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace loomstone::test {

class LastingThread {
 public:
  LastingThread() {
    std::thread([this] { work(); }).detach();
  }
  void start(std::function<void()> job) {
    const std::lock_guard<std::mutex> lock(mutex_);
    job_ = std::move(job);
    changed_.notify_all();
  }
  void wait() {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, [this] { return !job_; });
  }

 private:
  [[noreturn]] void work() {
    std::unique_lock<std::mutex> lock(mutex_);
    while (true) {
      changed_.wait(lock, [this] { return static_cast<bool>(job_); });
      job_();
      job_ = nullptr;
      changed_.notify_all();
    }
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::function<void()> job_;  // empty: the thread waits
};

// Calls job(i) for i = 0 to n - 1, each in a thread of its own, and waits for all of them. `job`
// must not throw. Only the main thread may call this function.
inline void run_together(int n, const std::function<void(int)>& job) {
  omp_get_max_threads();  // the main thread becomes the first thread of OpenMP
  static auto& threads = *new std::vector<std::unique_ptr<LastingThread>>;
  while (static_cast<int>(threads.size()) < n) threads.push_back(std::make_unique<LastingThread>());
  for (int i = 0; i < n; ++i) threads[i]->start([&job, i] { job(i); });
  for (int i = 0; i < n; ++i) threads[i]->wait();
}

}  // namespace loomstone::test
