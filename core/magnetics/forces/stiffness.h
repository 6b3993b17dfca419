// How stiff the forces between magnets are, as an upper bound of oscillation frequencies: what an
// explicit integrator must resolve. Every magnet, and every coil as the magnet of its bore, is
// taken as a few dipoles on a lattice, close enough that none is far longer than wide; the
// derivative of the force between two dipoles a distance r apart is at most 24 mu0/4pi m m' / r^5,
// that of the torque 2 mu0/4pi m m' / r^3. Dipoles of solid magnets do not come closer than their
// own size.
#pragma once

#include <memory>
#include <vector>

#include "core/magnetics/sources/body.h"

namespace loomstone {

struct CoarseMagnet {
  std::shared_ptr<const Points> positions;  // (n x 3) of dipoles, in the axes of the source [m]
  double moment = 0.0;                      // of each [A m^2]
  double size = 0.0;                        // edge of the part that each stands for; 0: points [m]
  bool soft_sphere = false;                 // see SoftSphere
};

CoarseMagnet coarse_magnet(const Source& source);

// What carries magnets.
struct Carrier {
  double inverse_mass = 0.0;     // [1/kg], 0: does not give way
  double inverse_inertia = 0.0;  // largest, about `centre` [1/(kg m^2)]
  Vec3 centre = Vec3::Zero();    // [m]
};

// Bound of the square of the angular frequency of every carrier [1/s^2]; field: the uniform one,
// size [T]. Magnets of one carrier do not act on one another. What soft spheres feel from one
// another and from what does not give way is left to add_sphere_frequencies2.
std::vector<double> frequencies2(const std::vector<CoarseMagnet>& magnets,
                                 const std::vector<RigidPose>& poses,
                                 const std::vector<Index>& carrier,
                                 const std::vector<Carrier>& carriers, double field);

// Spheres that magnetise along the field (chi > 0): they feel no torque, and only forces that drive
// them back count, with their moments held, since moments that follow the field lower the energy of
// any displacement further.
struct SoftSphere {
  Index carrier;
  Vec3 position, moment;  // [m], [A m^2]
  double radius;          // [m]
};
// Adds what they do to one another.
void add_sphere_frequencies2(const Team& team, const std::vector<SoftSphere>& spheres,
                             const std::vector<Carrier>& carriers,
                             std::vector<double>& frequencies2);
// A magnet that does not give way, and the gradient of its field at spheres (n x 9) [T/m].
struct FixedMagnet {
  const CoarseMagnet& magnet;
  const RigidPose& pose;
  const Gradients& gradient;
};
// Adds what it does to them: of a field that falls as r^-3 the second derivative is 4 / r times the
// gradient, and r is at least a sphere's radius; nor is it more than that of its dipoles, where
// these are few.
void add_sphere_frequencies2(const Team& team, const std::vector<SoftSphere>& spheres,
                             const FixedMagnet& by, const std::vector<Carrier>& carriers,
                             std::vector<double>& frequencies2);

}  // namespace loomstone
