// Boundary element method for the surface charge of a linear body in an applied field. It solves
// the integral equation of the second kind
//   (1/chi + 1/2) sigma - K sigma = n.H,
// where n.H is the normal component of the applied field, and K sigma is that of the field of the
// charge, averaged over both sides of the surface. The charge is uniform on each panel, and the
// equation is integrated over each panel (Galerkin).
//
// By Gauss' law, the flux of a panel's charge through the whole surface, averaged over both sides,
// is half of this charge. The diagonal entries of K are set such that each column sums to exactly
// this value. A rank-one term in the equation keeps the net charge zero even if 1/chi vanishes. The
// method is valid for all chi from -1 (a superconductor) to infinity, except 0.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "core/magnetics/sources/flat_panels.h"
#include "core/parallel/team.h"

namespace loomstone {

using DenseMatrix = Eigen::MatrixXd;

// The matrix K of a shape (targets x sources) [m^2]. K_ij is the flux through panel i that a unit
// charge density on panel j causes.
class BoundaryElements {
 public:
  virtual ~BoundaryElements() = default;
  // The factorised equation. solve() returns the charge densities mu0 sigma [T] that the fluxes of
  // the applied field through the panels [T m^2] induce.
  class Factors {
   public:
    virtual ~Factors() = default;
    virtual Vector solve(const Vector& fluxes) const = 0;
  };
  virtual std::unique_ptr<Factors> factor(double susceptibility) const = 0;
};

// Returns the matrix for rectangles in the order of cuboid_panels(). The flux between near panels
// has a closed form [Akoun1984], and that between far panels is computed by quadrature over both.
// The charge is a sum of eight parts, each of which is even or odd along each axis. Every part has
// its own equation, with an eighth of the unknowns.
std::unique_ptr<BoundaryElements> cuboid_boundary_elements(const Team& team,
                                                           const std::vector<FlatPanel>& panels);
// Returns the matrix for triangles of a closed surface. Between near panels, the flux is computed
// from the field of the charged panel at 4 x 4 points of the other. Between far panels, it is
// computed by quadrature over both. The diagonal entries absorb the quadrature error, so that
// Gauss' law holds exactly.
std::unique_ptr<BoundaryElements> mesh_boundary_elements(const Team& team,
                                                         const std::vector<FlatPanel>& panels);

}  // namespace loomstone
