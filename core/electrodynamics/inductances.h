// Inductances of circuits: their own, mutual ones, and what bodies that they magnetise add.
#pragma once

#include <map>
#include <utility>
#include <vector>

#include "core/electrodynamics/circuit_response.h"
#include "core/electrodynamics/magnetic_model.h"

namespace loomstone {

struct Inductances {
  Eigen::MatrixXd own;         // (circuits x circuits) [H]
  Eigen::MatrixXd from_given;  // (circuits x coils with given currents) [H]
};

// Stage. Keeps the mutual inductance of each pair of coils that it was asked for last, for the
// relative pose at which that was: a pair at the same pose to the last bit has the same.
class MutualInductances {
 public:
  explicit MutualInductances(const MagneticModel& model) : model_(model) {}

  // coils: all coils at their poses, each with one ampere; response: that of the bodies they
  // magnetise, empty if there are none. Throws InvalidInput if diamagnetic bodies leave a circuit
  // without positive self-inductance.
  Inductances at(const std::vector<MagneticBody>& coils, const CircuitResponse& response);

 private:
  double mutual(const std::vector<MagneticBody>& coils, std::size_t j, std::size_t k);

  struct Known {
    RigidPose pose;  // of the second coil as seen from the first
    double value = 0.0;
  };
  const MagneticModel& model_;
  std::map<std::pair<std::size_t, std::size_t>, Known> known_;  // by places among the coils
};

}  // namespace loomstone
