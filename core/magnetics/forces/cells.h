// Magnets as hierarchies of dipole cells, section 6.3.2 of [Thomaszewski2010]. Level 0 is the
// bounding box. Cells are bisected along their longest axis until a given density of cells is
// reached. Leaves of volume v closer to the surface than half their diameter v^(1/3) are dropped,
// as are cells left without leaves. Each level carries the whole moment. For each pair of bodies
// (6.19) selects a front of cells.
//
// Departures: a cell stands at the mean of its leaves, not at the middle of its box. Its density in
// (6.19) is that of a cube of its longest edge. Cells of overlapping bodies closer than a leaf's
// diameter R feel F ~ 1/(R^3 r) and T ~ 1/R^3, which conserves angular momentum.
#pragma once

#include <vector>

#include "core/magnetics/fast_sums/expanded_field.h"
#include "core/magnetics/forces/interaction.h"

namespace loomstone {

struct Cell {
  Vec3 low, high;                // box [m]
  Vec3 position;                 // mean position of the leaves [m]
  double share = 0.0;            // share of the body's moment [1]
  Index children[2] = {-1, -1};  // -1: none
};

class CellMagnet final : public Source {
 public:
  // magnet: hard and solid; density: number of leaves per volume [1/m^3]; separation: a cell with
  // longest edge e is used at distances of at least separation * e [1], which equals r_0
  // rho_0^(1/3) in (6.19).
  CellMagnet(const Source& magnet, double density, double separation);
  // A copy whose field and gradient come from local expansions (expanded_field.h, with its
  // tolerance) in place of sums over all leaves. Fronts and forces between cells are the same.
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
  SourceRecipe recipe() const override {
    return {"cells", {{"density", density_}, {"separation", separation_}}, {}, magnet_};
  }

  const std::vector<Cell>& cells() const { return cells_; }  // the root first
  double leaf_diameter() const { return diameter_; }         // v^(1/3) [m]
  // The front towards a box at a pose in this body's axes: the coarsest cells that are far enough
  // from it for their size.
  std::vector<Index> front(const Vec3& low, const Vec3& high, const RigidPose& pose) const;

 private:
  Index build(const Source& magnet, const Vec3& low, const Vec3& high, double density);

  std::vector<Cell> cells_;
  Vec3 moment_;
  double radius_, density_, separation_, diameter_ = 0.0;
  std::shared_ptr<const SourceRecipe> magnet_;
  DipoleSet leaves_{Points(0, 3), Points(0, 3)};
  std::shared_ptr<const ExpandedField> expanded_;  // field of the leaves, or null
};

// The cells of a body; null if it has none.
const CellMagnet* cells_of(const MagneticBody& body);

// Positions and moments of cells in world axes.
struct CellTable {
  Points positions, moments;  // (n x 3) [m], [A m^2]
};
// All cells of one level, with leaves of coarser levels, or the front of `body` towards `other`.
// Throws InvalidInput if a body has no cells.
CellTable cell_level(const MagneticBody& body, Index level);
CellTable cell_front(const MagneticBody& body, const MagneticBody& other);

// Force on `on` and torque about its centre, exerted by `by`; both must have cells.
Wrench cell_wrench(const MagneticBody& on, const MagneticBody& by);

// Distance of two boxes [m], the second at a pose in the axes of the first; 0 if they overlap.
double box_distance(const Vec3& low, const Vec3& high, const Vec3& other_low,
                    const Vec3& other_high, const RigidPose& pose);

}  // namespace loomstone
