// What circuits add where bodies magnetise. A linear body answers with a moment that is linear in
// all currents, so forces are quadratic in them: found once an instant from what acts with some
// amperes in each circuit, both ways, and in each two. The flux that comes back through a coil is
// linear in the currents: inductance.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "core/magnetics/forces/interaction.h"

namespace loomstone {

// to += factor * what, carrier by carrier.
void add_times(std::vector<Wrench>& to, double factor, const std::vector<Wrench>& what);

struct CircuitResponse {
  // Quadratic part: of one ampere in each of two circuits, or twice that of one ampere in one (j ==
  // k).
  struct Pair {
    std::size_t j, k;
    std::vector<Wrench> wrenches;  // on each carrier [N/A^2, N m/A^2]
  };
  std::vector<std::vector<Wrench>> linear;  // of each circuit, on each carrier [N/A, N m/A]
  std::vector<Pair> quadratic;
  Eigen::MatrixXd inductances;  // (circuits x coils) of bodies [H]
};

// What acts with some current in each circuit.
struct CircuitTrial {
  std::vector<Wrench> wrenches;  // on each carrier
  Vector flux;  // (coils) through each by magnetised bodies, where it is wanted [Wb]
};

// circuits: their places among the coils; amperes: (circuits) as many as show beside what acts
// without them, which is `idle` [A]. Of the mutual inductance of two circuits the mean of both ways
// round is taken.
CircuitResponse circuit_response(const std::vector<std::size_t>& circuits, const Vector& amperes,
                                 const std::vector<Wrench>& idle,
                                 const std::function<CircuitTrial(const Vector&)>& trial);

}  // namespace loomstone
