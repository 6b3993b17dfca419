// Magnetically linear spheres, modelled as point dipoles that magnetise one another: m = alpha B
// with the polarisability alpha of a sphere. This equation is (6.17) of [Thomaszewski2010] with its
// misprint corrected. Here, B includes the field of all other spheres, which leads to a linear
// system. In [Thomaszewski2010], only permanent magnets contribute to B.
#pragma once

#include <vector>

#include "core/magnetics/sources/dipoles.h"

namespace loomstone {

// Returns the moment per flux density of a sphere with radius R and susceptibility chi >= -1. It is
// (4 pi R^3 / mu0) chi / (3 + chi) [A m^2/T].
double sphere_polarizability(double radius, double susceptibility);

// Returns the moments (n x 3) [A m^2] of spheres at positions (n x 3) [m] with polarisabilities (n)
// [A m^2/T] in an applied flux density (n x 3) [T]. GMRES solves m - alpha T m = alpha B, where T
// maps the moments m to the flux density at each sphere due to the others, and B is the applied
// flux density. The initial guess is `start` if it has n rows, and otherwise zero. The iteration
// stops at a relative residual of `tolerance`. Throws SolverFailure if 200 iterations do not
// suffice, for example because spheres overlap.
Points induced_moments(const Team& team, const Points& positions, const Vector& polarizabilities,
                       const Points& applied, double tolerance, const Points& start = {});

// Returns the moments like induced_moments(), but for given radii [m] and susceptibilities [1].
// Throws InvalidInput if an argument is invalid.
Points sphere_moments(const Team& team, const Points& positions, const std::vector<double>& radii,
                      const std::vector<double>& susceptibilities, const Points& applied,
                      double tolerance);

}  // namespace loomstone
