#include "core/electrodynamics/inductances.h"

#include <algorithm>

#include "core/base/message.h"
#include "core/magnetics/induction/mutual_inductance.h"

namespace loomstone {

double MutualInductances::mutual(const std::vector<MagneticBody>& coils, std::size_t j,
                                 std::size_t k) {
  const RigidPose pose = relative_pose(coils[k].pose, coils[j].pose);
  const auto known = known_.find({j, k});
  if (known != known_.end() && known->second.pose == pose) return known->second.value;
  const double tolerance = std::max(1e-2 * model_.tolerance, 1e-12);
  return (known_[{j, k}] = {pose, mutual_inductance(coils[j], coils[k], tolerance)}).value;
}

Inductances MutualInductances::at(const std::vector<MagneticBody>& coils,
                                  const CircuitResponse& response) {
  const std::vector<std::size_t>&given = model_.given, &circuits = model_.circuits;
  const auto m = static_cast<Eigen::Index>(circuits.size());
  Inductances result{Eigen::MatrixXd(m, m), Eigen::MatrixXd(m, given.size())};
  for (Eigen::Index a = 0; a < m; ++a) {
    result.own(a, a) = model_.coils[circuits[a]].coil.inductance;
    for (Eigen::Index b = 0; b < a; ++b)
      result.own(a, b) = result.own(b, a) = mutual(coils, circuits[b], circuits[a]);
    for (std::size_t g = 0; g < given.size(); ++g)
      result.from_given(a, g) =
          model_.coils[given[g]].coil.times.empty() ? 0.0 : mutual(coils, given[g], circuits[a]);
  }
  if (response.linear.empty()) return result;
  for (Eigen::Index a = 0; a < m; ++a) {
    for (Eigen::Index b = 0; b < m; ++b) result.own(a, b) += response.inductances(a, circuits[b]);
    for (std::size_t g = 0; g < given.size(); ++g)
      result.from_given(a, g) += response.inductances(a, given[g]);
    if (!(result.own(a, a) > 0.0))
      fail<InvalidInput>(
          "coils[{}].inductance must be that of the winding in air, more than the {:.6g} H by "
          "which diamagnetic bodies reduce it, got {} H",
          circuits[a], -response.inductances(a, circuits[a]),
          model_.coils[circuits[a]].coil.inductance);
  }
  return result;
}

}  // namespace loomstone
