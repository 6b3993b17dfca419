// What coils and bearings do to bodies in a kick, and the current of the circuit.
//
// A coil with current i feels i G and its partners -i G by balance of momentum, where G is the force per ampere; the same G
// times the velocities is its back-EMF, so that what a circuit loses the bodies gain, to the last bit of a kick: of length tau,
// at rest positions, with middle values (subscript m), L (i' - i) = tau (V - R i_m - G v_m), m (v' - v) = tau (F + G i_m).
#pragma once

#include <vector>

#include "core/magnetics/interaction.h"
#include "core/rigid/free_motion.h"
#include "core/sim/model.h"
#include "core/sim/state.h"

namespace loomstone {

// Stage.
class Currents {
 public:
  Currents(const Model& model, const std::vector<Rotor>& rotors);
  bool active() const { return !model_.coils.empty() || !model_.scene.bearings.empty(); }
  bool held(Index body) const { return model_.bearing_of_body[body] >= 0; }
  Vec3 axis(Index body) const { return model_.scene.bearings[model_.bearing_of_body[body]].axis.normalized(); }

  // Forces per ampere where magnets (of groups) and coils are at a time [s].
  void place(const RigidState& state, const std::vector<RigidPose>& obstacles, const std::vector<MagneticBody>& magnets,
             const std::vector<Index>& groups, double time);
  // A kick of `duration` about `time` [s]: adds to `wrenches` what coils and bearings do, advances the circuit.
  void kick(double time, double duration, const RigidState& state, const Points& momenta, std::vector<Wrench>& wrenches,
            CircuitState& circuit) const;

 private:
  struct Twist {
    Vec3 velocity, spin;
  };
  // Velocities in the middle of a kick by a wrench.
  Twist middle(Index body, double duration, const RigidState& state, const Points& momenta, const Wrench& wrench) const;
  double power(const std::vector<Wrench>& per_ampere, double duration, const RigidState& state, const Points& momenta,
               const std::vector<Wrench>& wrenches) const;

  const Model& model_;
  const std::vector<Rotor>& rotors_;
  std::vector<std::size_t> order_;                 // of coils, the circuit last
  std::vector<std::vector<Wrench>> per_ampere_;    // of each coil on each body [N/A, N m/A]
  std::vector<double> sense_;                      // of each coil's source: -1 where its commutator reverses it
};

}  // namespace loomstone
