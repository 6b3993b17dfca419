// The second derivative of hinge angles, weighted by moments: the part of the bending stiffness
// that Gauss-Newton omits. Derived from the gradient of [Bridson2003]; equals [Tamstorf2013].
#pragma once

#include "core/cloth/bending/hinge.h"
#include "core/linalg/block_matrix.h"

namespace loomstone {

// Hinges and the moments about them [N m], one entry per hinge, to be multiplied by `scale`.
struct HingeMoments {
  const HingeSet& hinges;
  const AlignedDoubles& moment;
  double scale;
};

// Adds scale sum_e moment_e d2 theta_e / dx2 to rows [begin, end) of `matrix`, hinges ascending for
// each row: same bits for any team and any row range. Symmetric, indefinite. Skips degenerate
// hinges.
void add_hinge_hessians(const Team& team, const HingeMoments& moments, const Points& x, Index begin,
                        Index end, BlockMatrix& matrix);

}  // namespace loomstone
