// Point dipoles: field (6.5), gradient, forces (6.10) and torques (6.11) of [Thomaszewski2010]. A
// dipole contributes nothing at its own position.
#pragma once

#include "core/magnetics/sources/source.h"

namespace loomstone {

struct Wrenches {
  Points forces;    // (n x 3) [N]
  Points torques;   // (n x 3) [N m]
  Vector energies;  // (n) -m.B of each dipole [J]
};

// Positions and moments (n x 3) in row-major order, the input of the kernels.
struct DipoleTable {
  const double *positions, *moments;  // [m], [A m^2]
  Index n;
};

class DipoleSet final : public Source {
 public:
  // `positions` (n x 3) [m] and `moments` (n x 3) [A m^2] are given in the axes of the set.
  DipoleSet(Points positions, Points moments);
  void field_block(const double* points, Index n, Quantity quantity, double* field) const override;
  void gradient_block(const double* points, Index n, double* gradient) const override;
  void field_and_gradient_block(const double* points, Index n, Quantity quantity, double* field,
                                double* gradient) const override;
  void potential_block(const double* points, Index n, double* potential) const override;
  double radius() const override;
  Vec3 moment() const override { return moments_.colwise().sum().transpose(); }
  const DipoleSet* dipoles() const override { return this; }
  SourceRecipe recipe() const override {
    return {"dipoles", {{"points", positions_}, {"moments", moments_}}, {}, {}};
  }
  const Points& positions() const { return positions_; }
  const Points& moments() const { return moments_; }
  DipoleTable table() const {
    return {positions_.data(), moments_.data(), static_cast<Index>(positions_.rows())};
  }

 private:
  Points positions_, moments_;
};

// Returns forces, torques and energies of the given dipoles (n x 3) in the field of the dipoles of
// `by`. Torques are about each dipole's own position. Exchanging the two sets reverses the total
// force up to rounding errors. `nearest` [m] regularises pairs at smaller distances R: 1/nearest^3
// replaces 1/R^3. Forces then grow only as 1/R, and torques stay bounded.
Wrenches dipole_forces(const Team& team, const Points& positions, const Points& moments,
                       const DipoleSet& by, double nearest = 0.0);

// Returns the interaction energy of a set of dipoles [J]. It is minus the sum of m_k . B_l(r_k)
// over all pairs k < l, where m_k and r_k are the moment and the position of dipole k, and B_l is
// the field of dipole l.
double dipole_energy(const Team& team, const DipoleSet& set);

// Kernels for one block of observers, stored as coordinate arrays x[n], y[n], z[n]; n is a multiple
// of 8.
void dipole_field_block(const DipoleTable& by, const double* points, Index n, double* field);
void dipole_gradient_block(const DipoleTable& by, const double* points, Index n, double* gradient);

struct DipoleColumns {
  const double *points, *moments;  // [m], [A m^2]
  Index n;
};
// `nearest2` [m^2] is the square of `nearest` in dipole_forces().
void dipole_force_block(const DipoleTable& by, const DipoleColumns& on, double nearest2,
                        double* field, double* force);

}  // namespace loomstone
