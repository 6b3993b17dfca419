// How stiff the forces between magnets are, as an upper bound of oscillation frequencies: what an explicit integrator must
// resolve. Every magnet is taken as a few dipoles on a lattice, close enough that none is far longer than wide; the
// derivative of the force between two dipoles a distance r apart is at most 24 mu0/4pi m m' / r^5, that of the torque 2 mu0/4pi
// m m' / r^3. Dipoles of solid magnets do not come closer than their own size.
#pragma once

#include <vector>

#include "core/magnetics/body.h"

namespace loomstone {

struct CoarseMagnet {
  Points positions;       // (n x 3) of dipoles, in the axes of the source [m]
  double moment = 0.0;    // of each [A m^2]
  double size = 0.0;      // edge of the part that each stands for; 0: points [m]
};

CoarseMagnet coarse_magnet(const Source& source);

// What carries magnets.
struct Carrier {
  double inverse_mass = 0.0;     // [1/kg], 0: does not give way
  double inverse_inertia = 0.0;  // largest, about `centre` [1/(kg m^2)]
  Vec3 centre = Vec3::Zero();    // [m]
};

// Bound of the square of the largest angular frequency [1/s^2]; field: the uniform one, size [T]. Magnets of one carrier do
// not act on one another.
double largest_frequency2(const std::vector<CoarseMagnet>& magnets, const std::vector<RigidPose>& poses,
                          const std::vector<Index>& carrier, const std::vector<Carrier>& carriers, double field);

}  // namespace loomstone
