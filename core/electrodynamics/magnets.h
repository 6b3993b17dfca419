// The magnets of a model at given poses: magnetisation of bodies, wrenches and energy.
#pragma once

#include <vector>

#include "core/electrodynamics/magnetic_model.h"

namespace loomstone {

// Magnets at one instant.
struct Magnetised {
  // Magnets in the order of the model. For a sphere treated as a point dipole, the moment is given
  // in world axes and the orientation is the identity.
  std::vector<MagneticBody> magnets;
  std::vector<KnownField> known;  // fields of hard magnets at induced dipoles, reused for forces
  // (dipoles x 3) Moments of the induced dipoles [A m^2]. If no magnet is an induced dipole, these
  // are the unchanged `moments` that at() received.
  Points moments;
  // Sum of saturation_energy() over the bodies with saturation [J].
  double saturation_energy = 0.0;
};

// Computes magnetisation, wrenches and energy. Contains only constant tables of the model. `model`
// must outlive the Magnets.
class Magnets {
 public:
  explicit Magnets(const MagneticModel& model);

  // Magnetises the induced magnets at the given poses. Returns all magnets, the known fields and
  // the induced dipole moments (see Magnetised). `coils` are additional field sources. `moments` is
  // an initial guess of the induced dipole moments.
  Magnetised at(const Team& team, const CarrierPlaces& places,
                const std::vector<MagneticBody>& coils, const Points& moments = Points()) const;
  // Returns the wrench on each carrier: the forces and torques on its magnets due to the uniform
  // field and to the magnets of other groups (see groups()).
  CarrierWrenches wrenches(const Team& team, const CarrierPlaces& places,
                           const Magnetised& magnetised) const;
  // Returns the energy of all magnets in each other's fields and in the uniform field, without
  // coils [J]. Pairs of hard magnets in one group (see groups()) do not count.
  double energy(const Team& team, const Magnetised& magnetised) const;

  const std::vector<Index>& hard() const { return hard_; }        // indices of hard magnets
  const std::vector<Index>& induced() const { return induced_; }  // indices of induced magnets
  // Returns MagneticModel::group() of each magnet's carrier.
  const std::vector<Index>& groups() const { return groups_; }
  bool dipoles_only() const { return !soft_; }  // whether all induced magnets are dipoles
  // Returns the polarisability of each induced magnet [A m^2/T], 0 unless it is a sphere.
  const Vector& polarizabilities() const { return polarizabilities_; }

 private:
  std::vector<MagneticBody> hard(const std::vector<MagneticBody>& magnets) const;
  Points dipole_positions(const std::vector<MagneticBody>& magnets) const;
  Points applied_field(const Team& team, const std::vector<MagneticBody>& coils,
                       Magnetised& magnetised) const;
  void magnetise_bodies(const Team& team, const std::vector<MagneticBody>& coils,
                        Magnetised& magnetised) const;
  void magnetise_dipoles(const Team& team, const std::vector<MagneticBody>& coils,
                         Magnetised& magnetised) const;

  const MagneticModel& model_;
  std::vector<Index> groups_, hard_, induced_;
  Vector polarizabilities_;
  bool soft_ = false;
};

// Returns all magnets for display, followed by the coils whose entry in `currents` (coils) [A] is
// not zero. Spheres treated as point dipoles are returned as magnetised spheres.
std::vector<MagneticBody> shown_magnets(const Team& team, const MagneticModel& model,
                                        const CarrierPlaces& places, const Vector& currents);

}  // namespace loomstone
