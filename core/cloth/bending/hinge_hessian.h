// The second derivative of hinge angles, weighted by moments: the part of the bending stiffness
// that Gauss-Newton leaves out. Derived from the gradient of method.md 1.2; equal to Tamstorf and
// Grinspun, Graph. Models 75 (2013).
#pragma once

#include "core/cloth/bending/hinge.h"
#include "core/linalg/block_matrix.h"

namespace loomstone {

// Adds scale sum_e moment_e d2 theta_e / dx2 to rows [begin, end) of `matrix`, hinges ascending for
// each row: same bits for any team and any row range. Symmetric, indefinite. moment: one entry a
// hinge; degenerate hinges are left out.
void add_hinge_hessians(const Team& team, const HingeSet& hinges, const AlignedDoubles& moment,
                        const Points& x, double scale, Index begin, Index end, BlockMatrix& matrix);

}  // namespace loomstone
