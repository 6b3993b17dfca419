// Forces between coils and magnets, per ampere, at one instant.
//
// A coil with current i feels i G and its partners -i G by balance of momentum, where G is the
// force per ampere; kicks (kick.h) also take its back-EMF from it.
#pragma once

#include <vector>

#include "core/electrodynamics/circuit_response.h"
#include "core/electrodynamics/magnetic_model.h"

namespace loomstone {

struct CoilForces {
  std::vector<CarrierWrenches> per_ampere;   // of each coil [N/A, N m/A]
  std::vector<CircuitResponse::Pair> pairs;  // of circuits on different carriers, and by what they
                                             // magnetise
  std::vector<double> sense;  // of each coil's source: -1 where its commutator reverses it
};

// Coils where they stand.
class PlacedCoils {
 public:
  // twists: of obstacles; two that rest exert nothing on one another that counts. `places` must
  // outlive this.
  PlacedCoils(const MagneticModel& model, const CarrierPlaces& places, std::vector<Twist> twists);

  const std::vector<MagneticBody>& with_one_ampere() const { return coils_; }

  // Wrenches between magnets and coils with currents (coils) [A].
  CarrierWrenches with_magnets(const std::vector<MagneticBody>& magnets,
                               const Vector& currents) const;
  // Wrenches among coils with such currents, and those of the uniform field on them.
  CarrierWrenches among_coils(const Vector& currents) const;
  // Per ampere at a time [s]. response: of circuits with magnets that they magnetise; empty: none
  // do, and they act on magnets as these are.
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
  // Whether the carriers never move against one another.
  bool joined(Index a, Index b) const;
  void meet(const Part& coil, const Part& other, double factor, CarrierWrenches& result) const;

  const MagneticModel& model_;
  std::vector<Twist> twists_;
  Points centres_;
  std::vector<MagneticBody> coils_;
};

}  // namespace loomstone
