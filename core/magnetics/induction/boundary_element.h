// Charge on the surface of a linear body in an applied field, the equation of the second kind
//   (1/chi + 1/2) sigma - K sigma = n.H,   K sigma the normal field of the charge, the mean of both
//   sides,
// with uniform charge on panels and both sides integrated over each (Galerkin). What flows out of a
// panel's charge through all panels is half of it: the sum of each column is that exactly, and a
// row of the net charge is added, so that the net charge is zero also where 1/chi vanishes. Valid
// for chi >= -1 (a superconductor) up to infinity.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "core/magnetics/sources/flat_panels.h"
#include "core/parallel/team.h"

namespace loomstone {

using DenseMatrix = Eigen::MatrixXd;

// Flux of each panel's unit charge through all others, (targets x sources) [m^2]; constant for a
// shape.
class BoundaryElements {
 public:
  virtual ~BoundaryElements() = default;
  // Factors of the equation, and its solution: charges from the fluxes of the applied field through
  // the panels.
  class Factors {
   public:
    virtual ~Factors() = default;
    virtual Vector solve(const Vector& fluxes) const = 0;
  };
  virtual std::unique_ptr<Factors> factor(double susceptibility) const = 0;
};

// Rectangles in the order of cuboid_panels: closed forms [Akoun1984], and an equation for each of
// the eight symmetries of the body, an eighth as large.
std::unique_ptr<BoundaryElements> cuboid_boundary_elements(const Team& team,
                                                           const std::vector<FlatPanel>& panels);
// Triangles of a closed surface: exact fields at points of the others. A panel's own share follows
// from Gauss' law, which stands for the curvature of what the panels approach, too.
std::unique_ptr<BoundaryElements> mesh_boundary_elements(const Team& team,
                                                         const std::vector<FlatPanel>& panels);

}  // namespace loomstone
