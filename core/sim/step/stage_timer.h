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

 private:
  double& seconds_;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace loomstone
