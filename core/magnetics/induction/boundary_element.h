// Boundary element method for the surface charge of a linear body in an applied field: the integral
// equation of the second kind
//   (1/chi + 1/2) sigma - K sigma = n.H,
// where K sigma is the normal field of the charge, averaged over both sides of the surface. Charge
// is uniform on panels, and both sides of the equation are integrated over each panel (Galerkin).
//
// By Gauss' law, half of the flux of a panel's charge leaves through the surface; diagonal entries
// are set so that each column sums to exactly that. A rank-one term for the net charge is added,
// which keeps the net charge zero even if 1/chi vanishes. Valid for chi >= -1 (a superconductor) up
// to infinity.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "core/magnetics/sources/flat_panels.h"
#include "core/parallel/team.h"

namespace loomstone {

using DenseMatrix = Eigen::MatrixXd;

// The matrix K of a shape: flux of each panel's unit charge density through all panels,
// (targets x sources) [m^2].
class BoundaryElements {
 public:
  virtual ~BoundaryElements() = default;
  // The factorised equation. solve() returns charge densities mu0 sigma [T] from the fluxes of the
  // applied field through the panels [T m^2].
  class Factors {
   public:
    virtual ~Factors() = default;
    virtual Vector solve(const Vector& fluxes) const = 0;
  };
  virtual std::unique_ptr<Factors> factor(double susceptibility) const = 0;
};

// Rectangles in the order of cuboid_panels: closed forms [Akoun1984], and one equation of an eighth
// of the size for each of the eight symmetry classes of the body.
std::unique_ptr<BoundaryElements> cuboid_boundary_elements(const Team& team,
                                                           const std::vector<FlatPanel>& panels);
// Triangles of a closed surface: exact fields at quadrature points of the others. Diagonal entries
// follow from Gauss' law, which also accounts for the curvature of the surface that the panels
// approximate.
std::unique_ptr<BoundaryElements> mesh_boundary_elements(const Team& team,
                                                         const std::vector<FlatPanel>& panels);

}  // namespace loomstone
