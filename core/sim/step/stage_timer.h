// Wall time of the stages of a step.
#pragma once

#include <chrono>

namespace loomstone {

// Adds the wall time of its lifetime to `seconds`.
class StageTimer {
 public:
  explicit StageTimer(double& seconds)
      : seconds_(seconds), start_(std::chrono::steady_clock::now()) {}
  ~StageTimer() {
    seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;

 private:
  double& seconds_;
  std::chrono::steady_clock::time_point start_;
};

// Runs a stage and adds its wall time to `seconds`.
template <class Stage>
void timed(double& seconds, Stage&& stage) {
  const StageTimer timer(seconds);
  stage();
}

}  // namespace loomstone
