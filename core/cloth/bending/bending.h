// Bending energies of a triangle mesh: the thesis' hinge and the mid-edge element, on the same
// interface.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/base/types.h"
#include "core/linalg/block_matrix.h"
#include "core/mesh/adjacency.h"
#include "core/mesh/triangle_mesh.h"
#include "core/parallel/row_layout.h"
#include "core/parallel/team.h"

namespace loomstone {

// What both elements are built from.
struct BendingSetup {
  Points rest_positions;  // (n x 3) shape in which rest angles are measured; flat cloth: any flat
                          // shape [m]
  Triangles triangles;    // (m x 3)
  std::vector<Corners2> corners;     // (m) rest coordinates in weft/warp axes [m]
  std::vector<Mat3> rigidity;        // (m) D for (kxx, kyy, 2 kxy) [N m]
  std::vector<double> damping;       // (m) beta of stiffness-proportional bending damping [s]
  std::vector<std::uint8_t> pinned;  // (n) 1: pinned or scripted from the start (rule R)
  bool flat_rest = true;             // rest angles zero; else measured on rest_positions
  std::vector<double> rest_angles;   // per hinge in the order of hinges(); empty: as flat_rest says
  // Mid-edge only: add_stiffness gives, instead of the Gauss-Newton matrix U^T Q U over pairs of
  // hinges, U^T diag(q) U with q_e = 1/2 sum_f |Q_ef|. That is never less than half of it
  // (Gershgorin), which is what linearly implicit steps need to be stable, on a third of its
  // blocks. Our choice.
  bool lumped_stiffness = false;
};

// Model of one bending element on all cloth. Scratch inside decides nothing, but an object serves
// one caller at a time.
class Bending {
 public:
  virtual ~Bending() = default;
  virtual const std::vector<Hinge>& hinges() const = 0;
  virtual const std::vector<double>& rest_angles() const = 0;
  // Vertex pairs coupled by the stiffness (for the matrix pattern of implicit bending).
  virtual std::vector<std::pair<Index, Index>> couplings() const = 0;

  virtual double energy(const Team& team, const Points& x) const = 0;
  // Adds the elastic plus damping force (minus energy gradient, minus beta Q theta_dot u) to rows
  // [begin, end) of `force`. Gathered per vertex in ascending order: same bits for any team and any
  // row range.
  virtual void add_forces(const Team& team, const Points& x, const Points& v, Index begin,
                          Index end, Points& force) const = 0;
  // Adds scale_k K + scale_d D (Gauss-Newton, PSD) to rows [begin, end) of `matrix`, whose pattern
  // holds couplings().
  virtual void add_stiffness(const Team& team, const Points& x, double scale_k, double scale_d,
                             Index begin, Index end, BlockMatrix& matrix) const = 0;
  // Adds scale times what the exact Hessian of the energy has beyond the Gauss-Newton stiffness:
  // moments times second derivatives of angles (indefinite; zero at rest).
  virtual void add_geometric_stiffness(const Team& team, const Points& x, double scale, Index begin,
                                       Index end, BlockMatrix& matrix) const = 0;
  // Largest eigenvalue of M^-1 K at rest by power iteration [1/s^2]; explicit steps need h <= 0.8 *
  // 2 / sqrt(it).
  virtual double largest_eigenvalue(const Vector& mass) const = 0;

  // Edges whose slope is the plain mean of their triangles' because the triangles are slivers
  // (mid-edge; else 0).
  virtual Index averaged_edges() const = 0;
  // Hinges that exert no force because one of their triangles has no area in the shape x.
  virtual Index degenerate_hinges(const Team& team, const Points& x) const = 0;
};

// The thesis' hinge with k = 4 B. It depends on the mesh and does not converge: effective rigidity
// 0.8 B on grids along their axes, 0.83-0.96 B on smoothed irregular meshes (least in narrow
// strips), 0.7 ... 2.2 B at 45 degrees to a grid.
std::unique_ptr<Bending> make_hinge_bending(const BendingSetup& setup);
// Curvature of each triangle from the slopes at its mid-edges; beam theory within 1 % on every
// mesh.
std::unique_ptr<Bending> make_midedge_bending(const BendingSetup& setup);

}  // namespace loomstone
