// Magnets as hierarchies of dipole cells, section 6.3.2. Level 0 is the bounding box; cells are
// bisected along their longest axis down to a density, leaves closer to the surface than half their
// diameter v^(1/3) are dropped, empty cells with them, and every level carries the whole moment.
// For a pair of bodies a front of cells is chosen by (6.19). Departures: a cell stands at the mean
// of its leaves rather than at the middle of its box, its density in (6.19) is that of a cube of
// its longest edge, and cells closer than a leaf's diameter R (of overlapping bodies) feel F ~
// 1/(R^3 r), T ~ 1/R^3, which keeps angular momentum.
#pragma once

#include <vector>

#include "core/magnetics/fast_sums/expanded_field.h"
#include "core/magnetics/forces/interaction.h"

namespace loomstone {

struct Cell {
  Vec3 low, high;                // its box [m]
  Vec3 position;                 // mean of its leaves [m]
  double share = 0.0;            // of the body's moment [1]
  Index children[2] = {-1, -1};  // -1: none
};

class CellMagnet final : public Source {
 public:
  // magnet: hard and solid; density: of the leaves [1/m^3]; separation: a cell of longest edge e
  // serves at distances from separation * e on [1], which is r_0 times the cubic root of rho_0 in
  // (6.19).
  CellMagnet(const Source& magnet, double density, double separation);
  // The same; field and gradient at points come from expansions [expanded_field.h] to a tolerance
  // as there, not from a sum over all leaves. Fronts and forces between cells are what they are.
  CellMagnet expanded(double tolerance) const;
  void field_block(const double* points, Index n, Quantity quantity, double* field) const override;
  void gradient_block(const double* points, Index n, double* gradient) const override;
  void field_and_gradient_block(const double* points, Index n, Quantity quantity, double* field,
                                double* gradient) const override;
  void potential_block(const double* points, Index n, double* potential) const override {
    leaves_.potential_block(points, n, potential);
  }
  double radius() const override { return radius_; }
  Vec3 moment() const override { return moment_; }
  const DipoleSet* dipoles() const override { return &leaves_; }

  const std::vector<Cell>& cells() const { return cells_; }  // the first is the root
  double leaf_diameter() const { return diameter_; }         // v^(1/3) [m]
  // Cells that serve at the distances their boxes have from a box at a pose, both in this body's
  // axes.
  std::vector<Index> front(const Vec3& low, const Vec3& high, const RigidPose& pose) const;

 private:
  Index build(const Source& magnet, const Vec3& low, const Vec3& high, double density);

  std::vector<Cell> cells_;
  Vec3 moment_;
  double radius_, separation_, diameter_ = 0.0;
  DipoleSet leaves_{Points(0, 3), Points(0, 3)};
  std::shared_ptr<const ExpandedField> expanded_;  // of the leaves, or null
};

// The cells of a body; null where it has none.
const CellMagnet* cells_of(const MagneticBody& body);

// Cells as world positions and moments.
struct CellTable {
  Points positions, moments;  // (n x 3) [m], [A m^2]
};
// All cells of one level (leaves above it count as theirs), or the front of `body` towards `other`.
// InvalidInput where a body has no cells.
CellTable cell_level(const MagneticBody& body, Index level);
CellTable cell_front(const MagneticBody& body, const MagneticBody& other);

// Force and torque about its centre on `on` by `by`, both CellMagnets.
Wrench cell_wrench(const MagneticBody& on, const MagneticBody& by);

// Distance of two boxes, the second at a pose in the axes of the first [GJK88].
double box_distance(const Vec3& low, const Vec3& high, const Vec3& other_low,
                    const Vec3& other_high, const RigidPose& pose);

}  // namespace loomstone
