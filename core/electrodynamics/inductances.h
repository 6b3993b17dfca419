// Self and mutual inductances of circuits, with the contributions of magnetised bodies.
#pragma once

#include <map>
#include <utility>
#include <vector>

#include "core/electrodynamics/circuit_response.h"
#include "core/electrodynamics/magnetic_model.h"

namespace loomstone {

struct Inductances {
  Eigen::MatrixXd own;  // self and mutual inductances (circuits x circuits) [H]
  // Mutual inductances of circuits (rows) and coils with given currents (columns) [H]. Only their
  // products with changes of the given currents are needed. The columns of coils without
  // Coil::times, whose current is constant, are therefore 0.
  Eigen::MatrixXd from_given;
};

// Computes the inductances. The most recent mutual inductance of each pair of coils is cached
// together with the relative pose of the coils. It is reused if the relative pose is exactly the
// same again.
class MutualInductances {
 public:
  explicit MutualInductances(const MagneticModel& model) : model_(model) {}

  // `coils` contains all coils at their poses, each with one ampere. `response` is the response of
  // magnetised bodies to the circuits, or empty if there are no such bodies. Throws InvalidInput if
  // diamagnetic bodies leave a circuit without positive self-inductance, or if two loops whose
  // mutual inductance is needed coincide.
  Inductances at(const std::vector<MagneticBody>& coils, const CircuitResponse& response);

 private:
  double mutual(const std::vector<MagneticBody>& coils, std::size_t j, std::size_t k);

  struct Known {
    RigidPose pose;  // pose of the second coil of the key relative to the first coil of the key
    double value = 0.0;
  };
  const MagneticModel& model_;
  std::map<std::pair<std::size_t, std::size_t>, Known> known_;  // key: indices of the two coils
};

}  // namespace loomstone
