// Geometric bending stiffness: the second derivatives of the hinge angles, weighted by the hinge
// moments. The Gauss-Newton stiffness omits this part. The formulas are derived from the gradient
// in [Bridson2003] and agree with [Tamstorf2013].
#pragma once

#include "core/cloth/bending/hinge.h"
#include "core/linalg/block_matrix.h"

namespace loomstone {

// Hinges and their moments [N m], one entry per hinge. `scale` multiplies the moments.
struct HingeMoments {
  const HingeSet& hinges;
  const AlignedDoubles& moment;
  double scale;
};

// Adds scale * sum_e moment_e d2 theta_e / dx2 to rows [begin, end) of `matrix`. The added matrix
// is symmetric and indefinite. Hinges with a zero-area triangle are skipped. Hinges are added in
// ascending order for each row, so the result is bitwise identical for any number of threads and
// any row range.
void add_hinge_hessians(const Team& team, const HingeMoments& moments, const Points& x, Index begin,
                        Index end, BlockMatrix& matrix);

}  // namespace loomstone
