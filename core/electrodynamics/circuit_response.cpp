#include "core/electrodynamics/circuit_response.h"

namespace loomstone {

namespace {

// Returns for each carrier the weighted sum of its wrenches in `parts`.
CarrierWrenches combined(const std::vector<std::pair<double, const CarrierWrenches*>>& parts) {
  CarrierWrenches sum(parts.front().second->size());
  for (const auto& [factor, wrenches] : parts) add_times(sum, factor, *wrenches);
  return sum;
}

}  // namespace

CircuitResponse circuit_response(const std::vector<std::size_t>& circuits, const Vector& amperes,
                                 const CarrierWrenches& idle,
                                 const std::function<CircuitTrial(const Vector&)>& trial) {
  const std::size_t m = circuits.size();
  const auto with = [&](std::size_t j, double sign) {
    Vector currents = Vector::Zero(amperes.size());
    currents[static_cast<Eigen::Index>(j)] = sign * amperes[static_cast<Eigen::Index>(j)];
    return currents;
  };
  std::vector<CarrierWrenches> forth;
  CircuitResponse response;
  for (std::size_t j = 0; j < m; ++j) {
    const auto row = static_cast<Eigen::Index>(j);
    const double i = amperes[row];
    const CircuitTrial on = trial(with(j, 1.0)), back = trial(with(j, -1.0));
    forth.push_back(on.wrenches);
    response.linear.push_back(combined({{0.5 / i, &on.wrenches}, {-0.5 / i, &back.wrenches}}));
    response.quadratic.push_back(
        {j, j,
         combined(
             {{1 / (i * i), &on.wrenches}, {1 / (i * i), &back.wrenches}, {-2 / (i * i), &idle}})});
    if (j == 0) response.inductances.resize(static_cast<Eigen::Index>(m), on.flux.size());
    response.inductances.row(row) = (on.flux - back.flux).transpose() / (2.0 * i);
    for (std::size_t k = 0; k < j; ++k) {
      const CircuitTrial both = trial(with(j, 1.0) + with(k, 1.0));
      const double scale = 1.0 / (i * amperes[static_cast<Eigen::Index>(k)]);
      response.quadratic.push_back({k, j,
                                    combined({{scale, &both.wrenches},
                                              {-scale, &forth[j]},
                                              {-scale, &forth[k]},
                                              {scale, &idle}})});
    }
  }
  for (std::size_t j = 0; j < m; ++j)
    for (std::size_t k = 0; k < j; ++k) {
      double &one = response.inductances(static_cast<Eigen::Index>(j),
                                         static_cast<Eigen::Index>(circuits[k])),
             &other = response.inductances(static_cast<Eigen::Index>(k),
                                           static_cast<Eigen::Index>(circuits[j]));
      one = other = 0.5 * (one + other);
    }
  return response;
}

}  // namespace loomstone
