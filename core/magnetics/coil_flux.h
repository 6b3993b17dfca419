// Flux of magnetised bodies through coils, by reciprocity: the integral of their magnetisation times the coil's field of one
// ampere. Of bodies without inner charge that is one over their surface charge q and the scalar potential psi of the coil,
// - mu0 sum of q psi, with the branch of psi that is continuous in the body: of one in the bore psi grows along it.
#pragma once

#include "core/magnetics/body.h"

namespace loomstone {

// [Wb] through all turns of a loop or solenoid of one ampere a turn, by dipoles or by an induced body that lies in its bore,
// beyond its ends or beside it. Throws Unsupported where the body reaches round the winding, InvalidInput for other sources.
double linked_flux(const MagneticBody& coil, const MagneticBody& magnetised);

}  // namespace loomstone
