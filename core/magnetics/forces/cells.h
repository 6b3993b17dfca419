// Magnets as hierarchies of dipole cells, section 6.3.2 of [Thomaszewski2010]. Level 0 is the
// bounding box. Cells are bisected across their longest edge until there is a given number of cells
// per volume. A leaf of volume v is dropped unless its centre lies inside the magnet, at least half
// its diameter v^(1/3) below the surface. Cells without leaves are dropped too. If no leaf remains,
// one cell represents the whole magnet. The moments of the cells at each level, with the leaves of
// coarser levels, add up to the moment of the magnet. For each pair of bodies, equation (6.19)
// selects the cells that interact. These cells are called the front.
//
// There are three differences from [Thomaszewski2010]. The position of a cell is the mean position
// of its leaves, not the centre of its box. In (6.19), a cell with longest edge e counts with the
// density 1/e^3 of a cube with this edge. If two cells are closer than the smaller leaf diameter R
// of the two bodies, their force at the distance r is F ~ 1/(R^3 r), and their torque is
// T ~ 1/R^3. This law conserves angular momentum.
#pragma once

#include <vector>

#include "core/magnetics/fast_sums/expanded_field.h"
#include "core/magnetics/forces/interaction.h"

namespace loomstone {

struct Cell {
  Vec3 low, high;                // corners of the box [m]
  Vec3 position;                 // mean position of the leaves [m]
  double share = 0.0;            // fraction of the body's moment
  Index children[2] = {-1, -1};  // indices of the child cells; -1 for none
};

class CellMagnet final : public Source {
 public:
  // `magnet` must be hard and solid. Cells are bisected until there are at least `density` cells
  // per volume [1/m^3]. Unless it is a leaf, a cell with longest edge e is only used at distances
  // of at least `separation` times e. `separation` [1] equals r_0 rho_0^(1/3) in (6.19).
  CellMagnet(const Source& magnet, double density, double separation);
  // Returns a copy whose field and gradient come from local expansions instead of sums over all
  // leaves. For `tolerance`, see ExpandedField. The potential, the results of front() and the
  // forces between cells do not change.
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

  const CellMagnet* cell_magnet() const override { return this; }
  const std::vector<Cell>& cells() const { return cells_; }  // the first one is the root
  double leaf_diameter() const { return diameter_; }         // cube root of the leaf volume [m]
  // Returns the indices of the cells in the front towards a box whose pose is given in this body's
  // axes. These are the coarsest cells that are far enough from the box for their size, and leaves
  // elsewhere.
  std::vector<Index> front(const Vec3& low, const Vec3& high, const RigidPose& pose) const;

 private:
  Index build(const Source& magnet, const Vec3& low, const Vec3& high, double density);

  std::vector<Cell> cells_;
  Vec3 moment_;
  double radius_, density_, separation_, diameter_ = 0.0;
  std::shared_ptr<const SourceRecipe> magnet_;
  DipoleSet leaves_{Points(0, 3), Points(0, 3)};
  std::shared_ptr<const ExpandedField> expanded_;  // see expanded(); null if not used
};

// Positions and moments of cells in world axes.
struct CellTable {
  Points positions, moments;  // (n x 3) [m], [A m^2]
};
// cell_level() returns all cells of one level, including leaves of coarser levels. cell_front()
// returns the cells that CellMagnet::front() chooses for `body` towards `other`. Both throw
// InvalidInput if a body has no cells.
CellTable cell_level(const MagneticBody& body, Index level);
CellTable cell_front(const MagneticBody& body, const MagneticBody& other);

// Returns the force and the torque that `by` exerts on `on`. The torque is about the centre of
// `on`. Both bodies must have cells.
Wrench cell_wrench(const MagneticBody& on, const MagneticBody& by);

// Returns the distance between two boxes [m], or 0 if they overlap. `pose` is the pose of the
// second box in the axes of the first.
double box_distance(const Vec3& low, const Vec3& high, const Vec3& other_low,
                    const Vec3& other_high, const RigidPose& pose);

}  // namespace loomstone
