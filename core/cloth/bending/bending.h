// Bending energies of a triangle mesh with one interface: the thesis' hinge and the mid-edge
// element.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/base/types.h"
#include "core/cloth/material/jacobian_terms.h"
#include "core/linalg/block_matrix.h"
#include "core/mesh/adjacency.h"
#include "core/mesh/triangle_mesh.h"
#include "core/parallel/row_layout.h"
#include "core/parallel/team.h"

namespace loomstone {

// Description that both elements are built from.
struct BendingSetup {
  Points rest_positions;  // (n x 3) shape in which rest angles are measured; flat cloth: any flat
                          // shape [m]
  Triangles triangles;    // (m x 3)
  std::vector<Corners2> corners;  // (m) rest coordinates in weft/warp axes [m]
  std::vector<Mat3> rigidity;     // (m) D for (kxx, kyy, 2 kxy) [N m]
  std::vector<double> damping;    // (m) beta of stiffness-proportional bending damping [s]
  std::vector<std::uint8_t>
      prescribed;                   // (n) 1: prescribed; prescribed triangles clamp (midedge_setup)
  bool flat_rest = true;            // true: rest angles are zero; false: those of rest_positions
  std::vector<double> rest_angles;  // per hinge in the order of hinges(); empty: see flat_rest
  // Mid-edge only: add_stiffness replaces the Gauss-Newton matrix U^T Q U over pairs of hinges by
  // U^T diag(q) U with q_e = 1/2 sum_f |Q_ef|. This is an upper bound of half that matrix
  // (Gershgorin), sufficient for stable linearly implicit steps, with a third of its blocks. Our
  // choice.
  bool lumped_stiffness = false;
};

// Model of one bending element on all cloths. Contains scratch, so an object serves one caller at a
// time.
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
  // Adds elastic K + viscous D (Gauss-Newton, positive semi-definite) to rows [begin, end) of
  // `matrix`, whose pattern contains couplings().
  virtual void add_stiffness(const Team& team, const Points& x, StiffnessScales scales, Index begin,
                             Index end, BlockMatrix& matrix) const = 0;
  // Adds scale times the part of the exact Hessian that Gauss-Newton omits: moments times second
  // derivatives of angles (indefinite; zero at rest).
  virtual void add_geometric_stiffness(const Team& team, const Points& x, double scale, Index begin,
                                       Index end, BlockMatrix& matrix) const = 0;
  // Largest eigenvalue lambda of M^-1 K at rest by power iteration [1/s^2]; explicit steps need
  // h <= 0.8 * 2 / sqrt(lambda).
  virtual double largest_eigenvalue(const Vector& mass) const = 0;

  // Number of edges whose slope is the plain mean of their triangles' slopes because the triangles
  // are slivers (mid-edge; hinge: 0).
  virtual Index averaged_edges() const = 0;
  // Number of hinges that exert no force because one of their triangles has no area at x.
  virtual Index degenerate_hinges(const Team& team, const Points& x) const = 0;
};

// The thesis' hinge with k = 4 B. It depends on the mesh and does not converge: effective rigidity
// 0.8 B on grids along their axes, 0.83-0.96 B on smoothed irregular meshes (least in narrow
// strips), 0.7 ... 2.2 B at 45 degrees to a grid.
std::unique_ptr<Bending> make_hinge_bending(const BendingSetup& setup);
// Curvature of each triangle from the slopes at its mid-edges; agrees with beam theory within 1 %
// on every mesh.
std::unique_ptr<Bending> make_midedge_bending(const BendingSetup& setup);

}  // namespace loomstone
