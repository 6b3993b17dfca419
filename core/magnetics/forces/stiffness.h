// Upper bounds of the oscillation frequencies that forces between magnets cause, which an explicit
// integrator must resolve. Every magnet, and every coil as the magnet that fills its bore, is
// approximated by dipoles at the middles of nearly cubic parts. The derivative of the force between
// two dipoles at a distance r is at most 24 mu0/4pi m m' / r^5, that of the torque at most
// 2 mu0/4pi m m' / r^3. Dipoles of solid magnets come no closer than the size of their parts.
#pragma once

#include <memory>
#include <vector>

#include "core/magnetics/sources/body.h"

namespace loomstone {

struct CoarseMagnet {
  std::shared_ptr<const Points> positions;  // (n x 3) dipoles in the axes of the source [m]
  double moment = 0.0;                      // of each dipole [A m^2]
  double size = 0.0;                        // edge of the part of each; 0 for point dipoles [m]
  bool soft_sphere = false;                 // see SoftSphere
};

CoarseMagnet coarse_magnet(const Source& source);

// The rigid body that carries magnets; with zero inverse mass and inertia it does not move.
struct Carrier {
  double inverse_mass = 0.0;     // [1/kg]
  double inverse_inertia = 0.0;  // largest, about `centre` [1/(kg m^2)]
  Vec3 centre = Vec3::Zero();    // [m]
};

// Bounds of the squared angular frequency of every carrier [1/s^2]. carrier: that of each magnet;
// field: norm of the uniform field [T]. Magnets on one carrier do not act on one another. Forces of
// soft spheres on one another, and of fixed magnets on them, are left to add_sphere_frequencies2.
std::vector<double> frequencies2(const std::vector<CoarseMagnet>& magnets,
                                 const std::vector<RigidPose>& poses,
                                 const std::vector<Index>& carrier,
                                 const std::vector<Carrier>& carriers, double field);

// A sphere that magnetises along the field (chi > 0). It feels no torque. Only restoring forces at
// constant moments count, because moments that follow the field lower the energy of any
// displacement further.
struct SoftSphere {
  Index carrier;
  Vec3 position, moment;  // [m], [A m^2]
  double radius;          // [m]
};
// Adds the forces of soft spheres on one another.
void add_sphere_frequencies2(const Team& team, const std::vector<SoftSphere>& spheres,
                             const std::vector<Carrier>& carriers,
                             std::vector<double>& frequencies2);
// A magnet that does not move, and the gradient of its field at the spheres (n x 9) [T/m].
struct FixedMagnet {
  const CoarseMagnet& magnet;
  const RigidPose& pose;
  const Gradients& gradient;
};
// Adds the forces of a fixed magnet on soft spheres. The second derivative of a field that falls as
// r^-3 is 4 / r times its gradient, and r is at least a sphere's radius; the sum over the dipoles
// of the magnet, if they are few, is a second bound.
void add_sphere_frequencies2(const Team& team, const std::vector<SoftSphere>& spheres,
                             const FixedMagnet& by, const std::vector<Carrier>& carriers,
                             std::vector<double>& frequencies2);

}  // namespace loomstone
