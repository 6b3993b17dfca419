// Upper bounds of the frequencies at which magnetic forces make bodies oscillate. An explicit
// integrator must resolve these frequencies. A solid magnet is approximated by dipoles at the
// centres of up to 64 equal parts of its bounding box. A loop or solenoid is treated as a magnet
// that fills its bore and is at least one radius long. Point dipoles and magnets divided into cells
// keep their dipoles. A polyline counts as one part of size Source::radius(), with a dipole at its
// origin. At a distance r, the force between two dipoles with moments m and m' changes by at most
// 24 mu0/4pi m m' / r^5 per displacement, and the torque by at most 2 mu0/4pi m m' / r^3 per angle.
// If r is less than the mean size of the two parts that the dipoles represent, this mean size
// replaces r.
#pragma once

#include <memory>
#include <vector>

#include "core/magnetics/sources/body.h"

namespace loomstone {

struct CoarseMagnet {
  std::shared_ptr<const Points> positions;  // of the dipoles, in the source's axes (n x 3) [m]
  double moment = 0.0;                      // largest moment of a dipole [A m^2]
  double size = 0.0;                        // size of a part [m]; 0 for dipoles
  bool soft_sphere = false;                 // true: the magnet is also given as a SoftSphere
};

CoarseMagnet coarse_magnet(const Source& source);

// Rigid body that carries magnets. It is fixed if its inverse mass and inverse inertia are zero.
struct Carrier {
  double inverse_mass = 0.0;     // [1/kg]
  double inverse_inertia = 0.0;  // largest inverse moment of inertia about `centre` [1/(kg m^2)]
  Vec3 centre = Vec3::Zero();    // centre of mass in world axes [m]
};

// Returns upper bounds of the squared angular frequency of every carrier [1/s^2]. `carrier`
// contains the index of each magnet's carrier, and `field` is the norm of the uniform field [T].
// Magnets on one carrier do not interact. The bounds omit the forces between soft spheres and the
// forces of fixed magnets on soft spheres, which add_sphere_frequencies2() takes into account.
std::vector<double> frequencies2(const std::vector<CoarseMagnet>& magnets,
                                 const std::vector<RigidPose>& poses,
                                 const std::vector<Index>& carrier,
                                 const std::vector<Carrier>& carriers, double field);

// A sphere whose moment is parallel to the field (chi > 0), so that it experiences no torque. The
// stiffness of the forces on it is computed for constant moments. The result is an upper bound,
// because the stiffness is smaller if the moments follow the field.
struct SoftSphere {
  Index carrier;
  Vec3 position, moment;  // [m], [A m^2]
  double radius;          // [m]
};
// Adds the contribution of the forces between soft spheres to `frequencies2`. The distance between
// two centres counts as at least 0.9 times the sum of the radii.
void add_sphere_frequencies2(const Team& team, const std::vector<SoftSphere>& spheres,
                             const std::vector<Carrier>& carriers,
                             std::vector<double>& frequencies2);
// A fixed magnet, and the gradient of its field at the spheres (n x 9) [T/m].
struct FixedMagnet {
  const CoarseMagnet& magnet;
  const RigidPose& pose;
  const Gradients& gradient;
};
// Adds the contribution of the force of a fixed magnet on soft spheres to `frequencies2`. The
// stiffness is the moment of a sphere times the second derivative of the field. For a field that
// falls as r^-3 with the distance r from its source, this derivative is 4 / r times the gradient.
// Because r is at least the sphere's radius, 4 / radius times the gradient is a bound. If the
// magnet has at most 64 dipoles, a sum over them gives another bound, and the smaller one is used.
void add_sphere_frequencies2(const Team& team, const std::vector<SoftSphere>& spheres,
                             const FixedMagnet& by, const std::vector<Carrier>& carriers,
                             std::vector<double>& frequencies2);

}  // namespace loomstone
