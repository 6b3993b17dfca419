// Helpers for the tests of simulations: mesh pointers, step options, and a comparison of
// checkpoints that ignores their texts.
#pragma once

#include <memory>
#include <utility>

#include "core/sim/simulation.h"

namespace loomstone::test {

inline std::shared_ptr<const TriangleMesh> share(TriangleMesh mesh) {
  return std::make_shared<const TriangleMesh>(std::move(mesh));
}

inline IntegratorOptions step_of(double h, std::string_view method = "semi-implicit-euler") {
  IntegratorOptions options = integrator_named(method);
  options.set_step(h);
  return options;
}

inline bool same(const Checkpoint& a, const Checkpoint& b) {
  if (a.integers != b.integers || a.bytes != b.bytes || a.arrays.size() != b.arrays.size())
    return false;
  for (const auto& [name, array] : a.arrays)
    if (array.shape != b.arrays.at(name).shape || array.values != b.arrays.at(name).values)
      return false;
  return true;
}

}  // namespace loomstone::test
