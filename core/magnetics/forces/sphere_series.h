// Convergence of the series of solid harmonics that describes the response of a sphere to nearby
// sources.
#pragma once

#include "core/magnetics/sources/body.h"

namespace loomstone {

// Returns the distance [m] of a point from a body. If the source has dipoles, this is the distance
// from the nearest one. Otherwise, it is the distance from the surface of a solid source, negative
// inside, or from the nearest sampled point of a current. A uniformly magnetised sphere counts as
// the dipole at its centre.
double distance_to_source(const MagneticBody& body, const Vec3& point);

// Each of the next two functions returns the number x such that terms of degree l of the force on a
// sphere of the given radius [m] decay as exp(-x l), or 1e-3 if x is smaller. `distance` [m] is
// that of the nearest source from the sphere's centre. In the second function, this source is
// another sphere with induced charge. `other` [m] is its radius, and `distance` that of its centre.
double sphere_decay(double radius, double distance);
double sphere_decay(double radius, double other, double distance);

// Returns the degree of the series with which the relative error of the force is about `tolerance`,
// but at most SphericalHarmonics::most. `decay` is the result of sphere_decay().
int degree_of(double decay, double tolerance);

// Returns an estimate of the error of the force between a sphere and a dipole that is due to the
// truncation of the series, relative to the force that the series gives [1].
double truncated_share(const SeriesEnd& end);

}  // namespace loomstone
