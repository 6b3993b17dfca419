// Spheres that magnetise in the field they are in, and one another: point dipoles m = alpha B with
// the response of a linear sphere, (6.17) as it must read. The field of all others counts, as a
// linear system, where the thesis lets only permanent magnets magnetise.
#pragma once

#include <vector>

#include "core/magnetics/sources/dipoles.h"

namespace loomstone {

// Moment over flux density of a sphere of susceptibility chi >= -1 [A m^2/T]: 4 pi R^3 / mu0 chi /
// (3 + chi).
double sphere_polarizability(double radius, double susceptibility);

// (n x 3) moments [A m^2] of spheres at (n x 3) positions [m] with polarizabilities (n) in the
// applied flux density (n x 3) [T], to a relative residual of `tolerance`: generalised minimal
// residuals [Saad1986] on m - alpha T m = alpha B, from moments they may be near to (start, if as
// many). Throws SolverFailure where that is not reached in 200 iterations (spheres deep in one
// another).
Points induced_moments(const Team& team, const Points& positions, const Vector& polarizabilities,
                       const Points& applied, double tolerance, const Points& start = {});

// The same from radii [m] and susceptibilities (n), checked (throws InvalidInput).
Points sphere_moments(const Team& team, const Points& positions, const std::vector<double>& radii,
                      const std::vector<double>& susceptibilities, const Points& applied,
                      double tolerance);

}  // namespace loomstone
