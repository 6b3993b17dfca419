// What coils and bearings do to bodies in a kick, and the currents of circuits.
//
// A coil with current i feels i G and its partners -i G by balance of momentum, where G is the
// force per ampere; the same G times the velocities is its back-EMF, so that what a circuit loses
// the bodies gain, to the last bit of a kick: of length tau, at rest positions, with middle values
// (subscript m), L (i' - i) = tau (V - R i_m - G v_m), m (v' - v) = tau (F + G i_m). With several
// circuits L is the matrix of their own and mutual inductances, to which M di/dt of the given
// currents is added, and G of each contains the currents of the others: what they do to one another
// in a kick is taken at i_m, by iteration, and half of it is stored in L as bodies move. The same
// holds for what a circuit does to itself by bodies that it magnetises (circuit_response.h), whose
// flux adds to L. What moves by script has its velocities in G v too; it feels nothing, and its
// work counts as supply.
#pragma once

#include <map>
#include <vector>

#include "core/magnetics/forces/interaction.h"
#include "core/rigid/free_motion.h"
#include "core/electrodynamics/circuit_response.h"
#include "core/sim/model/model.h"
#include "core/sim/model/state.h"

namespace loomstone {

// (coils) currents at a time [s], given or of circuits [A]; of the first circuit, 0 without one.
Vector coil_currents(const Model& model, const State& state, double time);
double first_circuit_current(const Model& model, const State& state);

// Where bodies and then obstacles are, about which wrenches on them count (carriers x 3) [m].
Points carrier_centres(const RigidState& state, const std::vector<RigidPose>& obstacles);

// The winding of a coil with a current in each turn [A].
SourcePtr wound_source(const Coil& coil, double current);

// The coils that carry a current, each at its place; currents: (coils) [A].
std::vector<MagneticBody> carrying_coils(const Model& model, const RigidState& state,
                                         const std::vector<RigidPose>& obstacles,
                                         const Vector& currents);

// Whether anything follows from the flux of magnetised bodies through a coil.
bool wants_flux(const Coil& coil);

// Stage.
class Currents {
 public:
  Currents(const Model& model, const std::vector<Rotor>& rotors);
  bool active() const { return !model_.coils.empty() || !model_.scene.bearings.empty(); }
  bool held(Index body) const { return model_.bearing_of_body[body] >= 0; }
  Vec3 axis(Index body) const {
    return model_.scene.bearings[model_.bearing_of_body[body]].axis.normalized();
  }

  const std::vector<std::size_t>& circuits() const {
    return circuits_;
  }  // their places among the coils
  // (coils) the currents that are given at a time [s], and those of the circuits if any are told
  // [A].
  Vector all(double time, const Vector& circuits = {}) const;
  // Obstacles go from one place to the other in `step` [s]; call before place().
  void move(const std::vector<RigidPose>& from, const std::vector<RigidPose>& to, double step);
  std::vector<std::uint8_t> resting() const;  // which obstacles do not move, as last told
  // What coils with currents (coils) and magnets do to one another, on each body and obstacle.
  std::vector<Wrench> on_magnets(const RigidState& state, const std::vector<RigidPose>& obstacles,
                                 const std::vector<MagneticBody>& magnets,
                                 const Vector& currents) const;
  // What coils with such currents do to one another and feel from the uniform field, likewise.
  std::vector<Wrench> on_coils(const RigidState& state, const std::vector<RigidPose>& obstacles,
                               const Vector& currents) const;
  // Forces per ampere where magnets and coils are at a time [s]. magnetised: forces on the bodies
  // that magnets exert on one another because coils of given currents magnetise some of them; their
  // work is that of the sources of these currents. response: of circuits with magnets that they
  // magnetise; no rows: none do, and they act on magnets as these are.
  void place(const RigidState& state, const std::vector<RigidPose>& obstacles,
             const std::vector<MagneticBody>& magnets, double time, std::vector<Wrench> magnetised,
             const CircuitResponse& response);
  // A kick of `duration` about `time` [s]: adds to `wrenches` what coils and bearings do, advances
  // the circuits.
  void kick(double time, double duration, const RigidState& state, const Points& momenta,
            std::vector<Wrench>& wrenches, CircuitState& circuits);

 private:
  using Wrenches = std::vector<Wrench>;  // on each body; per ampere on each body and obstacle
  struct Twist {
    Vec3 velocity, spin;
    bool rests() const { return velocity.isZero(0.0) && spin.isZero(0.0); }
  };
  using Pair = CircuitResponse::Pair;  // places in circuits_
  double given_current(std::size_t coil, double time) const;
  std::vector<MagneticBody> placed_coils(const RigidState& state,
                                         const std::vector<RigidPose>& obstacles) const;
  struct Part {
    const MagneticBody& body;
    Index carrier;
  };
  // Whether the carriers never move against one another.
  bool joined(Index a, Index b) const;
  void meet(const Part& coil, const Part& other, double factor, const Points& centres,
            Wrenches& result) const;
  void place_inductances(const std::vector<MagneticBody>& coils, const CircuitResponse& response);
  void advance_circuits(double time, double duration, const RigidState& state,
                        const Points& momenta, Wrenches& wrenches, CircuitState& circuits) const;
  // Velocities in the middle of a kick by a wrench.
  Twist middle(Index body, double duration, const RigidState& state, const Points& momenta,
               const Wrench& wrench) const;
  // Per ampere [W/A]: of what bodies feel, and of what obstacles would feel.
  double power(const Wrenches& per_ampere, double duration, const RigidState& state,
               const Points& momenta, const Wrenches& wrenches) const;
  double scripted_power(const Wrenches& per_ampere) const;

  const Model& model_;
  const std::vector<Rotor>& rotors_;
  std::vector<std::size_t> given_, circuits_;  // coils with given currents, with circuits
  std::vector<Twist> scripted_;                // of each obstacle [m/s, rad/s]
  std::vector<Wrenches> per_ampere_;           // of each coil [N/A, N m/A]
  std::vector<Pair> pairs_;  // of circuits on different bodies, and by what they magnetise
  Wrenches magnetised_;
  Eigen::MatrixXd inductances_, from_given_;  // (circuits x circuits), (circuits x given) [H]
  std::vector<double> sense_;  // of each coil's source: -1 where its commutator reverses it
  // Mutual inductances at the relative poses they were last asked for.
  struct Known {
    RigidPose pose;
    double value = 0.0;
  };
  std::map<std::pair<std::size_t, std::size_t>, Known> known_;
};

}  // namespace loomstone
