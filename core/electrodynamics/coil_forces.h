// Forces per ampere of coil current at one instant, between coils and magnets and among coils.
//
// Let G be the force per ampere on a coil. At the current i, the coil feels i G. By conservation of
// momentum, the magnets and other coils that exert this force together feel -i G. Kicks (kick.h)
// compute the back-EMF of the coil from the same G.
#pragma once

#include <vector>

#include "core/electrodynamics/circuit_response.h"
#include "core/electrodynamics/magnetic_model.h"

namespace loomstone {

struct CoilForces {
  // (coils) For each coil, the wrenches on the carriers per ampere of its current, without those in
  // `pairs` [N/A, N m/A]. The interaction of a circuit and a coil with given current is part of the
  // entry of the circuit. The interaction of two coils with given currents is part of the entry of
  // the coil with the higher index.
  std::vector<CarrierWrenches> per_ampere;
  // Interactions of circuits. Those through magnetised bodies include the action of a circuit on
  // itself. Direct interactions of two circuits on one carrier, or on obstacles at rest, are
  // omitted.
  std::vector<CircuitResponse::Pair> pairs;
  std::vector<double> sense;  // (coils) 1, or -1 if a commutator reverses the voltage
};

// Coils at given poses, and the forces on them.
class PlacedCoils {
 public:
  // `twists` is the motion of the obstacles. Forces within one carrier (a body or obstacle) and
  // forces between two obstacles at rest are not computed. `model` must outlive the object.
  PlacedCoils(const MagneticModel& model, const CarrierPlaces& places, std::vector<Twist> twists);

  const std::vector<MagneticBody>& with_one_ampere() const { return coils_; }

  // Returns the wrenches between `magnets` (in the order of MagneticModel::magnets) and coils that
  // carry `currents` (coils) [A].
  CarrierWrenches with_magnets(const std::vector<MagneticBody>& magnets,
                               const Vector& currents) const;
  // Returns the wrenches among coils that carry `currents` (coils) [A], plus the wrenches of the
  // uniform field on the coils.
  CarrierWrenches among_coils(const Vector& currents) const;
  // Returns the forces per ampere, the interactions of circuits and the commutation at `time` [s].
  // `response` is the response of magnetised bodies to the circuits. If it is empty, the circuits
  // magnetise no bodies, and their forces on `magnets` are computed directly.
  CoilForces per_ampere(const std::vector<MagneticBody>& magnets, double time,
                        const CircuitResponse& response) const;

 private:
  struct Part {
    const MagneticBody& body;
    Index carrier;
  };
  Part coil(std::size_t j) const { return {coils_[j], model_.coils[j].carrier}; }
  Part magnet(const std::vector<MagneticBody>& magnets, std::size_t k) const {
    return {magnets[k], model_.magnets[k].carrier};
  }
  // Returns true if a and b are the same carrier, or if both are obstacles at rest in the step.
  bool joined(Index a, Index b) const;
  void meet(const Part& coil, const Part& other, double factor, CarrierWrenches& result) const;

  const MagneticModel& model_;
  std::vector<Twist> twists_;
  Points centres_;
  std::vector<MagneticBody> coils_;
};

}  // namespace loomstone
