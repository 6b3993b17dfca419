// Magnetisation of linear bodies by magnets, currents, a uniform field and one another. The
// excitation of a body represents the field that acts on its surface. R_i maps the excitation of
// body i to its charge, and G_ij maps the charge of body j to the excitation of body i. For two or
// more bodies, GMRES solves
//   x_i = R_i (applied_i + sum over j != i of G_ij x_j)
// for the charges x_i of all bodies at once, preconditioned by a block Gauss-Seidel sweep.
// applied_i is the excitation of body i by the magnets, the currents and the uniform field. A body
// that saturates counts as linear with an effective susceptibility, which is found by iteration.
#pragma once

#include <string>
#include <vector>

#include "core/magnetics/induction/soft_shape.h"

namespace loomstone {

struct Induction {
  // The soft bodies with their induced charge. The axes of spheres may be rotated.
  std::vector<MagneticBody> bodies;
  double residual = 0.0;                 // relative residual of the linear system [1]
  int iterations = 0;                    // total number of GMRES iterations
  std::vector<double> susceptibilities;  // effective susceptibility of each body [1]
};

// Magnetises `soft` in the field of `hard` and the uniform field `field` [T] to a relative residual
// of `tolerance`. If the degree of a sphere's harmonics is automatic, it is chosen for `tolerance`,
// too. In a body with the saturation magnetisation M_s, the volume means of M and H satisfy
// M = chi H / (1 + chi |H| / M_s). The effective susceptibility chi (1 - |M| / M_s) is the same
// everywhere in this body. Throws SolverFailure if no equilibrium is found, and InvalidInput if
// `tolerance` is not in [1e-14, 0.1] or `field` is not finite.
Induction induce(const Team& team, const std::vector<SoftBody>& soft,
                 const std::vector<MagneticBody>& hard, const Vec3& field, double tolerance);

// Returns the magnetic energy [J] of a body with saturation minus that of a linear body with the
// same effective susceptibility c (`effective`). Let V be the volume, H the field inside the body,
// and U(c) the energy of the linear body in a constant applied field. Then U'(c) = -mu0 H^2 V / 2.
// The force of the applied field on the body with saturation is that of the energy U(c) + g(c) if
// g'(c) = -U'(c). With H = M_s (1/c - 1/chi), the function returns
//   g(c) = -mu0 M_s^2 V / (2 c) (1 - r^2 + 2 r ln r),   r = c / chi.
// It returns 0 for a body without saturation and for infinite c.
double saturation_energy(const SoftBody& body, double effective);

// Throws InvalidInput if a soft body overlaps another soft body or a magnet. Two bodies overlap if
// a sample of the soft body lies inside the other body, or if the centre or a dipole of the other
// body lies inside the soft body. Bodies may touch. Currents are not checked. The message names
// both bodies. `names` contains the names of the soft bodies, followed by those of the hard ones.
void check_apart(const std::vector<SoftBody>& soft, const std::vector<MagneticBody>& hard,
                 const std::vector<std::string>& names);

// Returns the explicit response of [Thomaszewski2010], as dipoles at the positions `cells` [m] in
// the axes of the body. Each cell responds only to the field of `hard` and the uniform field
// `field` [T]. It responds as a sphere (6.17) or, in a superconductor (chi = -1), with M = -B / mu0
// (6.18). Throws InvalidInput for a body with saturation.
MagneticBody explicit_response(const SoftBody& body, const Points& cells,
                               const std::vector<MagneticBody>& hard, const Vec3& field);
// Divides a body into cells of equal volume and returns their positions (n x 3) [m]. `density` is
// the minimum number of cells per volume [1/m^3]; see CellMagnet.
Points explicit_cells(const SoftShape& shape, double density);

}  // namespace loomstone
