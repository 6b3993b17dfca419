// Flux of magnetised bodies through coils, by reciprocity: the integral of their magnetisation
// times the coil's field of one ampere. Of bodies without inner charge that is one over their
// surface charge q and the scalar potential psi of the coil,
// - mu0 sum of q psi, with the branch of psi that is continuous in the body: of one in the bore psi
// grows along it.
#pragma once

#include "core/magnetics/sources/body.h"

namespace loomstone {

// Where a body lies that does not cut the winding: all of it that is beside the turns is in the
// bore, or outside. Of a body that reaches round the winding both are; beyond the ends neither.
struct BesideWinding {
  bool in_bore = false, outside = false;
};
// body: a solid one, told by its surface where that is polygons, else taken for a ball.
BesideWinding beside_winding(const MagneticBody& coil, const MagneticBody& body);

// [Wb] through all turns of a loop or solenoid of one ampere a turn, by dipoles or by an induced
// body. Throws Unsupported where the body reaches round the winding.
double linked_flux(const MagneticBody& coil, const MagneticBody& magnetised);

}  // namespace loomstone
