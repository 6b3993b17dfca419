// Upper bound on the oscillation frequencies of bodies that carry magnets or coils
// (core/magnetics/forces/stiffness.h), and the rate of their relative motion
// (core/magnetics/forces/relative_motion.h). Sub-steps must resolve both.
#pragma once

#include <cstdint>
#include <vector>

#include "core/electrodynamics/magnets.h"
#include "core/magnetics/forces/relative_motion.h"
#include "core/magnetics/forces/stiffness.h"

namespace loomstone {

// Input from which SubstepFrequency computes an upper bound on frequencies, at one instant.
struct Oscillators {
  const CarrierPlaces& places;
  const std::vector<MagneticBody>& magnets;  // magnetisation includes the effect of `currents`
  const std::vector<KnownField>& known;      // fields of hard magnets at induced dipoles
  const Vector& currents;                    // (coils) [A]
  std::vector<std::uint8_t> touching;        // (bodies) 1: body in contact
};

// Computes an upper bound on the oscillation frequencies of bodies, and the rate of relative
// motion. Contains only constant tables of the model. `model` and `magnets` must outlive the
// SubstepFrequency.
class SubstepFrequency {
 public:
  SubstepFrequency(const MagneticModel& model, const Magnets& magnets);
  // Returns the largest of the bounds on the angular frequencies of the bodies [rad/s]. The bounds
  // of bodies in contact are first divided by four.
  double at(const Team& team, const Oscillators& now) const;
  // Returns the relative_motion_rate() of magnets and coils [1/s], or a larger value of at most
  // `negligible`. In a uniform field, the rate is at least the angular velocity of any coil and of
  // any body that carries a magnet other than a SoftSphere. `motions` are those of bodies, then
  // obstacles.
  double motion_rate(const Team& team, const CarrierPlaces& places,
                     const std::vector<CarrierMotion>& motions, double negligible) const;

 private:
  // All magnets, then all coils, each approximated by dipoles, with its pose and its group.
  struct Coarse {
    std::vector<CoarseMagnet> magnets;
    std::vector<RigidPose> poses;
    std::vector<Index> groups;
  };
  std::vector<Carrier> carriers(const CarrierPlaces& places) const;
  bool all_soft_spheres() const;
  std::vector<SoftSphere> spheres(const std::vector<MagneticBody>& magnets) const;
  Coarse coarse(const Oscillators& now, const std::vector<SoftSphere>& spheres) const;
  void add_spheres(const Team& team, const Oscillators& now, const Coarse& coarse,
                   const std::vector<SoftSphere>& spheres, const std::vector<Carrier>& carriers,
                   std::vector<double>& squares) const;

  const MagneticModel& model_;
  const Magnets& magnets_;
  std::vector<CoarseMagnet> coarse_, coarse_coils_;  // each coil carries one ampere
  // All magnets, then all coils, and their carriers, for motion_rate().
  std::vector<CoarseMagnet> moving_;
  std::vector<Index> moving_carriers_;
};

}  // namespace loomstone
