// The magnets of a model at their poses: how bodies magnetise, what magnets do to one another, and
// their energy.
#pragma once

#include <vector>

#include "core/electrodynamics/magnetic_model.h"

namespace loomstone {

// Magnets at one instant.
struct Magnetised {
  // In the order of the model; induced dipoles as dipoles with world axes.
  std::vector<MagneticBody> magnets;
  std::vector<KnownField> known;  // of hard magnets at induced dipoles, used again by forces
  Points moments;                 // (k x 3) of induced dipoles, or those given without any [A m^2]
};

// Stage without state: tables of the model.
class Magnets {
 public:
  explicit Magnets(const MagneticModel& model);

  // Coils magnetise bodies too; moments: of induced dipoles, from which their search begins.
  Magnetised at(const Team& team, const CarrierPlaces& places,
                const std::vector<MagneticBody>& coils, const Points& moments = Points()) const;
  // Wrenches on each carrier by magnets in one another's field and in the uniform one.
  CarrierWrenches wrenches(const Team& team, const CarrierPlaces& places,
                           const Magnetised& magnetised) const;
  // Energy of all magnets in one another's field and in the uniform one, without coils [J].
  double energy(const Team& team, const Magnetised& magnetised) const;

  const std::vector<Index>& hard() const { return hard_; }        // places in the list of magnets
  const std::vector<Index>& induced() const { return induced_; }  // the others
  const std::vector<Index>& groups() const { return groups_; }    // MagneticModel::group of each
  bool dipoles_only() const { return !soft_; }  // the induced ones are spheres taken as dipoles
  const Vector& polarizabilities() const { return polarizabilities_; }  // of the induced, then

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

// All magnets as pictures show them, spheres that are dipoles as magnetised spheres, and then the
// coils that carry a current; currents: (coils) [A].
std::vector<MagneticBody> shown_magnets(const Team& team, const MagneticModel& model,
                                        const CarrierPlaces& places, const Vector& currents);

}  // namespace loomstone
