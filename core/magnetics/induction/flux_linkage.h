// Flux linkage of magnetised bodies with coils, by reciprocity. It is the integral, over the body,
// of the dot product of the magnetisation and the flux density of a current of one ampere in the
// coil. For a body without volume charge, it equals -mu0 times the sum of q psi, where q is the
// surface charge of the body and psi the scalar potential of the coil. The branch of psi must be
// continuous in the body. For a body in the bore, psi therefore decreases along the bore in the
// field's direction.
#pragma once

#include "core/magnetics/sources/body.h"

namespace loomstone {

// Location of those parts of a body that lie between the heights of a winding's ends; heights are
// measured along the winding's axis. If the whole body lies beyond an end of the winding, both
// values are false. Both are true if, between these heights, some edges of the body's surface
// polygons are in the bore and some are outside it.
struct BesideWinding {
  bool in_bore = false, outside = false;
};
// Locates a solid body relative to a winding. If the body's surface contains polygons, their edges
// are tested. Otherwise, the distance of the body's centre from the axis decides, provided that the
// body's bounding sphere reaches between the heights of the winding's ends.
BesideWinding beside_winding(const MagneticBody& coil, const MagneticBody& body);

// Returns the flux of dipoles or of an induced body through a loop or solenoid, summed over its
// turns [Wb]. `coil` must carry one ampere per turn. Throws Unsupported if a body with surface
// charge lies both in the bore and outside the winding.
double linked_flux(const MagneticBody& coil, const MagneticBody& magnetised);

}  // namespace loomstone
