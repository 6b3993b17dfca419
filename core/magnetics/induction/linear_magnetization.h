// Magnetisation of linear bodies by magnets and by one another. With the response R_i of a single
// body and the field G_ij of one body's charge at another, the charges x_i = R_i (applied + sum of
// G_ij x_j) are found by GMRES for all bodies at once.
#pragma once

#include <string>
#include <vector>

#include "core/magnetics/induction/soft_shape.h"

namespace loomstone {

struct Induction {
  std::vector<MagneticBody> bodies;  // with their charge; axes of spheres may differ
  double residual = 0.0;             // relative, of the linear system [1]
  int iterations = 0;                // of GMRES
};

// Magnetises `soft` in the field of `hard` and a uniform one [T], to a relative residual of
// `tolerance`, which also chooses the degree of spheres. A body with saturation obeys
// M = chi H / (1 + chi |H| / M_s) in its volume means: its effective susceptibility is the single
// number chi (1 - |M| / M_s). Throws SolverFailure if no equilibrium is found.
Induction induce(const Team& team, const std::vector<SoftBody>& soft,
                 const std::vector<MagneticBody>& hard, const Vec3& field, double tolerance);

// Throws InvalidInput naming the first soft body that overlaps another one or a magnet. names: of
// the soft bodies, then of the hard ones.
void check_apart(const std::vector<SoftBody>& soft, const std::vector<MagneticBody>& hard,
                 const std::vector<std::string>& names);

// The explicit response of [Thomaszewski2010]: each cell responds as a sphere (6.17), or with M =
// -B / mu0 in a superconductor (6.18), to the field of the permanent magnets and the uniform field
// alone.
MagneticBody explicit_response(const SoftBody& body, const Points& cells,
                               const std::vector<MagneticBody>& hard, const Vec3& field);
// Positions (n x 3) of cells of equal volume with a density [1/m^3].
Points explicit_cells(const SoftShape& shape, double density);

}  // namespace loomstone
