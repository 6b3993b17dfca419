// The wall time of a stage of a step.
#pragma once

#include <chrono>

#include "core/base/report.h"

namespace loomstone {

// Adds the wall time of its life to a stage of the report.
class StageTimer {
 public:
  StageTimer(StepReport& report, StageName stage)
      : seconds_(report.seconds[static_cast<int>(stage)]),
        start_(std::chrono::steady_clock::now()) {}
  ~StageTimer() {
    seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;

 private:
  double& seconds_;
  std::chrono::steady_clock::time_point start_;
};

// Runs a stage and adds its wall time to the report.
template <class Stage>
void timed(StepReport& report, StageName name, Stage&& stage) {
  const StageTimer timer(report, name);
  stage();
}

}  // namespace loomstone
