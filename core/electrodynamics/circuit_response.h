// Response of magnetised bodies to circuits. A linear body answers with a moment that is linear in
// all currents, so forces are polynomials of second degree in them. Their coefficients are found at
// each instant from probe currents: of both signs in each circuit, and in each pair of circuits.
// The flux that bodies return through a coil is linear in the currents and adds to the inductances.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "core/electrodynamics/carriers.h"

namespace loomstone {

struct CircuitResponse {
  // Quadratic part: of one ampere in each of two circuits, or twice that of one ampere in one (j ==
  // k). Places among the circuits.
  struct Pair {
    std::size_t j, k;
    CarrierWrenches wrenches;  // [N/A^2, N m/A^2]
  };
  std::vector<CarrierWrenches> linear;  // of each circuit [N/A, N m/A]
  std::vector<Pair> quadratic;
  Eigen::MatrixXd inductances;  // (circuits x coils) of bodies [H]
};

// Wrenches and fluxes with some current in each circuit.
struct CircuitTrial {
  CarrierWrenches wrenches;
  Vector flux;  // (coils) through each by magnetised bodies, where it is wanted [Wb]
};

// circuits: their places among the coils; amperes: (circuits) large enough to show against what
// acts without them, which is `idle` [A]. The mutual inductance of two circuits is the mean of both
// ways round.
CircuitResponse circuit_response(const std::vector<std::size_t>& circuits, const Vector& amperes,
                                 const CarrierWrenches& idle,
                                 const std::function<CircuitTrial(const Vector&)>& trial);

}  // namespace loomstone
