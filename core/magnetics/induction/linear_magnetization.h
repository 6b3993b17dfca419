// Linear bodies that magnetise in the field they are in, and one another: x_i = R_i (applied + sum
// of G_ij x_j), with R_i the answer of one body, known, and G_ij the field of one's charge at
// another, solved by GMRES on all bodies at once.
#pragma once

#include <string>
#include <vector>

#include "core/magnetics/induction/soft_shape.h"

namespace loomstone {

struct Induction {
  std::vector<MagneticBody> bodies;  // as their charge is now; spheres may have been turned
  double residual = 0.0;             // of the linear system, relative
  int iterations = 0;                // of it
};

// soft: in the field of `hard` and a uniform one [T], to a relative residual of `tolerance`, which
// also chooses the degree of spheres. A body with saturation follows M = chi H / (1 + chi |H| /
// M_s) in its means over the volume: its susceptibility is one number, chi (1 - |M| / M_s). Throws
// SolverFailure where no equilibrium is found.
Induction induce(const Team& team, const std::vector<SoftBody>& soft,
                 const std::vector<MagneticBody>& hard, const Vec3& field, double tolerance);

// Throws InvalidInput naming the first soft body that lies in another or in a magnet; names: of the
// soft, then of the hard ones.
void check_apart(const std::vector<SoftBody>& soft, const std::vector<MagneticBody>& hard,
                 const std::vector<std::string>& names);

// The thesis' explicit response: cells that each answer as a sphere, (6.17), or with M = -B / mu0
// in a superconductor (6.18), to the field of the permanent magnets and the uniform one alone.
MagneticBody explicit_response(const SoftBody& body, const Points& cells,
                               const std::vector<MagneticBody>& hard, const Vec3& field);
// The cells (n x 3) of a density [1/m^3], of equal volume.
Points explicit_cells(const SoftShape& shape, double density);

}  // namespace loomstone
