#include "core/sim/circuit_response.h"

namespace loomstone {

namespace {

// The sum of some trials, each with its factor.
std::vector<Wrench> combined(const std::vector<std::pair<double, const CircuitTrial*>>& parts) {
  std::vector<Wrench> sum(parts.front().second->wrenches.size());
  for (const auto& [factor, trial] : parts) add_times(sum, factor, trial->wrenches);
  return sum;
}

}  // namespace

void add_times(std::vector<Wrench>& to, double factor, const std::vector<Wrench>& what) {
  for (std::size_t b = 0; b < to.size(); ++b) {
    to[b].force += factor * what[b].force;
    to[b].torque += factor * what[b].torque;
  }
}

CircuitResponse circuit_response(const std::vector<std::size_t>& circuits, const Vector& amperes,
                                 const std::function<CircuitTrial(const Vector&)>& trial) {
  const std::size_t m = circuits.size();
  const auto with = [&](std::size_t j, double sign) {
    Vector currents = Vector::Zero(amperes.size());
    currents[static_cast<Eigen::Index>(j)] = sign * amperes[static_cast<Eigen::Index>(j)];
    return currents;
  };
  const CircuitTrial idle = trial(Vector::Zero(amperes.size()));
  std::vector<CircuitTrial> forth;
  CircuitResponse response;
  response.inductances.resize(static_cast<Eigen::Index>(m), idle.flux.size());
  for (std::size_t j = 0; j < m; ++j) {
    const auto row = static_cast<Eigen::Index>(j);
    const double i = amperes[row];
    forth.push_back(trial(with(j, 1.0)));
    const CircuitTrial back = trial(with(j, -1.0));
    response.linear.push_back(combined({{0.5 / i, &forth[j]}, {-0.5 / i, &back}}));
    response.quadratic.push_back({j, j, combined({{1 / (i * i), &forth[j]}, {1 / (i * i), &back}, {-2 / (i * i), &idle}})});
    response.inductances.row(row) = (forth[j].flux - back.flux).transpose() / (2.0 * i);
    for (std::size_t k = 0; k < j; ++k) {
      const CircuitTrial both = trial(with(j, 1.0) + with(k, 1.0));
      const double scale = 1.0 / (i * amperes[static_cast<Eigen::Index>(k)]);
      response.quadratic.push_back(
          {k, j, combined({{scale, &both}, {-scale, &forth[j]}, {-scale, &forth[k]}, {scale, &idle}})});
    }
  }
  for (std::size_t j = 0; j < m; ++j)
    for (std::size_t k = 0; k < j; ++k) {
      double &one = response.inductances(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(circuits[k])),
             &other = response.inductances(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(circuits[j]));
      one = other = 0.5 * (one + other);
    }
  return response;
}

}  // namespace loomstone
