// Flux linkage of magnetised bodies with coils, by reciprocity: the integral of the magnetisation
// times the field of one ampere in the coil. For a body without volume charge it equals - mu0 sum
// of q psi, with its surface charge q and the scalar potential psi of the coil. The branch of psi
// must be continuous in the body: for a body in the bore, psi grows along the bore.
#pragma once

#include "core/magnetics/sources/body.h"

namespace loomstone {

// Which parts of a body are level with the turns of a winding: parts in the bore, parts outside,
// both for a body that reaches around the winding, neither for one beyond its ends.
struct BesideWinding {
  bool in_bore = false, outside = false;
};
// body: a solid body; its surface is tested if it consists of polygons, otherwise its bounding
// ball.
BesideWinding beside_winding(const MagneticBody& coil, const MagneticBody& body);

// Flux of dipoles or an induced body through all turns of a loop or solenoid with one ampere per
// turn [Wb]. Throws Unsupported if the body reaches around the winding.
double linked_flux(const MagneticBody& coil, const MagneticBody& magnetised);

}  // namespace loomstone
