// Common interface of the two bending elements: the hinge of [Thomaszewski2010] and the mid-edge
// element.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/own_rows.h"
#include "core/base/types.h"
#include "core/cloth/material/jacobian_terms.h"
#include "core/linalg/block_matrix.h"
#include "core/mesh/adjacency.h"
#include "core/mesh/triangle_mesh.h"
#include "core/parallel/row_layout.h"
#include "core/parallel/shared_work.h"
#include "core/parallel/team.h"

namespace loomstone {

// Input from which either bending element is built.
struct BendingSetup {
  // (n x 3) [m] Positions for largest_eigenvalue(), and for the rest angles if flat_rest is false
  // and rest_angles is empty.
  Points rest_positions;
  Triangles triangles;            // (m x 3)
  std::vector<Corners2> corners;  // (m) rest coordinates in weft/warp axes [m]
  std::vector<Mat3> rigidity;     // (m) flexural rigidity D for (kxx, kyy, 2 kxy) [N m]
  std::vector<double> damping;    // (m) beta of stiffness-proportional bending damping [s]
  std::vector<std::uint8_t>
      prescribed;                   // (n) 1: prescribed vertex; see midedge_setup.cpp for clamping
  bool flat_rest = true;            // true: zero rest angles; false: angles of rest_positions
  std::vector<double> rest_angles;  // [rad] in the order of hinges(); empty: see flat_rest
  // True: the mid-edge element replaces its Gauss-Newton matrix by a lumped matrix with about a
  // third of the blocks. The Gauss-Newton matrix is U^T Q U, where row e of U is the gradient of
  // the angle of hinge e, and Q couples pairs of hinges. The lumped matrix is U^T diag(q) U with
  // q_e = 1/2 sum_f |Q_ef|. By Gershgorin's theorem, it is an upper bound of half the Gauss-Newton
  // matrix. Such a bound suffices for stable linearly implicit steps. The lumped matrix is not
  // taken from the literature.
  bool lumped_stiffness = false;
  // (m) 1: the triangle has energy; 0: it has none, and serves only to find the curvature of nearby
  // triangles. Empty: all triangles have energy. The energies of disjoint sets of triangles add up
  // to the energy of their union.
  std::vector<std::uint8_t> acts;

  bool forces_only = false;  // true: the element has no tables for the stiffness
  // False: the element does not keep the rest positions, and largest_eigenvalue() must not be
  // called.
  bool keeps_rest = true;

  std::size_t bytes() const {
    return bytes_of(rest_positions, triangles, corners, rigidity, damping, prescribed, rest_angles,
                    acts);
  }
  bool acts_on(Index triangle) const { return acts.empty() || acts[triangle]; }
};

// The bending elements of one BendingSetup, all of the same kind. An object contains scratch
// memory, so calls to the same object must not overlap in time.
class Bending {
 public:
  virtual ~Bending() = default;
  virtual const std::vector<Hinge>& hinges() const = 0;
  virtual const std::vector<double>& rest_angles() const = 0;
  // Vertex pairs that the stiffness matrix couples. They determine its sparsity pattern.
  virtual std::vector<std::pair<Index, Index>> couplings() const = 0;

  virtual double energy(const Team& team, const Points& x) const = 0;
  // Sets sums[i] to the energy of the triangles 128 i to 128 i + 127, counted from the beginning of
  // `triangles` [J]. If `triangles` is the range of all triangles, the sums add up to energy(). The
  // sums must be 0 before the call, because none is set if there are no hinges. Call this function
  // only if sums_by_triangle() returns true.
  virtual void sum_energies(const Team& team, const Points& x, IndexRange triangles,
                            double* sums) const = 0;
  virtual bool sums_by_triangle() const = 0;
  // Adds the elastic force and the stiffness-proportional damping force to rows [begin, end) of
  // `force`. For each vertex, hinges are added in ascending order, so the result is bitwise
  // identical for any number of threads and any row range.
  virtual void add_forces(const Team& team, const Points& x, const Points& v, Index begin,
                          Index end, RowsOut force) const = 0;
  // Adds the stiffness K and the damping matrix D, multiplied by their factors in `scales`, to rows
  // [begin, end) of `matrix`. K has the Gauss-Newton or the lumped form, both of which are positive
  // semi-definite. The pattern of `matrix` must contain couplings().
  virtual void add_stiffness(const Team& team, const Points& x, StiffnessScales scales, Index begin,
                             Index end, BlockMatrix& matrix) const = 0;
  // Adds `scale` times the part of the exact Hessian that the Gauss-Newton matrix omits: the
  // moments times the second derivatives of the angles. This part is indefinite. It is zero at
  // rest.
  virtual void add_geometric_stiffness(const Team& team, const Points& x, double scale, Index begin,
                                       Index end, BlockMatrix& matrix) const = 0;
  // Returns the largest eigenvalue lambda of M^-1 K at the rest positions [1/s^2], slightly
  // underestimated by power iteration. M is the diagonal matrix of the vertex masses `mass` (n)
  // [kg], and K is the bending stiffness. Prescribed vertices do not move. If undamped bending is
  // the only force, symplectic Euler is stable near the rest positions in steps shorter than
  // 2 / sqrt(lambda) [s]. Requires BendingSetup::keeps_rest.
  virtual double largest_eigenvalue(const Vector& mass) const = 0;

  // Number of edges whose slope is the plain mean of the slopes of their two triangles, because a
  // weight (see midedge_setup.h) would exceed 1 in magnitude. Always 0 for the hinge element.
  virtual Index averaged_edges() const = 0;
  // Number of hinges that exert no force because one of their triangles has zero area at x.
  virtual Index degenerate_hinges(const Team& team, const Points& x) const = 0;

  virtual std::size_t bytes() const = 0;  // size of the tables and of the scratch memory [bytes]
};

// The hinge element of [Thomaszewski2010] with the stiffness k = 4 B for flexural rigidity B.
// Results depend on the mesh and do not converge under refinement. The effective rigidity is 0.8 B
// along the axes of regular grids, 0.83 to 0.96 B on smoothed irregular meshes (lowest in narrow
// strips), and 0.7 to 2.2 B at 45 degrees to a grid.
std::unique_ptr<Bending> make_hinge_bending(const BendingSetup& setup);
// The mid-edge element, which computes the curvature of each triangle from the slopes at its edge
// midpoints. It agrees with beam theory within 1 % on regular and irregular meshes.
std::unique_ptr<Bending> make_midedge_bending(const BendingSetup& setup);

}  // namespace loomstone
