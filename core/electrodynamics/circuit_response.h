// Response of magnetised bodies to circuit currents. The moment of a body that magnetises linearly
// is a linear function of all currents plus a constant, so forces are quadratic polynomials in the
// currents. The coefficients of these polynomials are determined at each instant with probe
// currents: positive and negative ones in each circuit alone, and positive ones in both circuits of
// each pair. The flux of the magnetised bodies through a coil changes in proportion to the circuit
// currents. The flux per ampere adds to the inductances.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "core/electrodynamics/carriers.h"

namespace loomstone {

struct CircuitResponse {
  // Second derivatives of the wrenches with respect to the currents of circuits j and k. The
  // indices j and k refer to the list of circuits and may be equal.
  struct Pair {
    std::size_t j, k;
    CarrierWrenches wrenches;  // [N/A^2, N m/A^2]
  };
  // (circuits) First derivatives of the wrenches with respect to the current of each circuit, at
  // zero circuit currents [N/A, N m/A].
  std::vector<CarrierWrenches> linear;
  std::vector<Pair> quadratic;
  Eigen::MatrixXd inductances;  // (circuits x coils) due to magnetised bodies [H]
};

// Wrenches and fluxes at one set of circuit currents.
struct CircuitTrial {
  CarrierWrenches wrenches;
  // (coils) Flux of magnetised bodies through each coil [Wb]; 0 where CarriedCoil::wants_flux() is
  // false.
  Vector flux;
};

// Determines the response. `circuits` contains the coil indices of the circuits. `amperes`
// (circuits) [A] are probe currents, large enough to have an effect comparable to `idle`, the
// wrenches without circuit currents. trial(currents) returns the wrenches and fluxes at the circuit
// currents `currents` (circuits) [A]. The mutual inductances M_jk and M_kj of two circuits are
// replaced by their mean.
CircuitResponse circuit_response(const std::vector<std::size_t>& circuits, const Vector& amperes,
                                 const CarrierWrenches& idle,
                                 const std::function<CircuitTrial(const Vector&)>& trial);

}  // namespace loomstone
