// Cartesian Taylor expansions of the potential of dipoles and charges: multipole moments M about a
// far centre a, local coefficients L about a near centre b, and their translations. With
// multi-indices n, m
//   phi(x) = sum_m M_m D_m(x - a),        D_m = d^m (1/r),                    far from a,
//          = sum_n L_n (x - b)^n / n!,    L_n = sum_m M_m D_{n+m}(b - a),     near b.
// The sums are truncated at |n| < order and |n| + |m| <= order. For dipoles, this truncation is
// symmetric in the two cells, so the forces between them are equal and opposite at any order
// [Dehnen2002]. Because 1/r is harmonic, a moment with a z exponent of at least 2 can be replaced:
// it is subtracted from the two moments whose z exponent is lower by 2 and whose x or y exponent is
// higher by 2. This leaves (order + 1)^2 moments, as many as in a spherical-harmonic expansion. All
// of L follows from its components with a z exponent of at most 1.
#pragma once

#include "core/magnetics/fast_sums/taylor_tables.h"

namespace loomstone {

class TaylorExpansion {
 public:
  static constexpr int highest_order = TaylorTables::highest_order;

  explicit TaylorExpansion(int order) : tables_(order) {}  // order: 3 ... highest_order

  int order() const { return tables_.order; }
  // moments_size() returns the number of multipole moments, which have z exponents of at most 1.
  // local_size() returns the number of local coefficients, which have any z exponent. Both kinds
  // are sorted by degree.
  int moments_size() const { return static_cast<int>(tables_.slim.size()); }
  int local_size() const { return static_cast<int>(tables_.powers.size()); }

  // Adds to `moments` the multipole moments of n dipoles about `centre`. `positions` and the dipole
  // moments `dipoles` are (n x 3).
  void add_dipoles(const double* positions, const double* dipoles, Index n, const Vec3& centre,
                   double* moments) const;
  // Adds to `moments` the multipole moments of n charges about `centre`. `positions` is (n x 3).
  void add_charges(const double* positions, const double* charges, Index n, const Vec3& centre,
                   double* moments) const;
  // Shifts the multipole moments of a child cell to a new centre, and adds them to `moments`
  // (multipole-to-multipole). The vector `shift` leads from the child's centre to the new centre.
  void add_moments(const double* child, const Vec3& shift, double* moments) const;

  struct Far {
    const double* moments;
    double arm[3];  // from the far cell's centre to the centre of `local`
  };
  // add_far() adds the potentials of n far cells to a local expansion (multipole-to-local). It adds
  // only to components with a z exponent of at most 1, and omits the constant, which does not
  // affect field and gradient. complete() computes the components with a z exponent of 2 or more
  // from the others.
  void add_far(const Far* far, Index n, double* local) const;
  void complete(double* local) const;
  // Shifts the complete expansion `parent` to a new centre, and adds its components with a z
  // exponent of at most 1, except the constant, to `local` (local-to-local). The vector `shift`
  // leads from the parent's centre to the new centre.
  void add_local(const double* parent, const Vec3& shift, double* local) const;

  // Computes -grad phi and its gradient (xx, xy, xz, yy, yz, zz) at n points, stored as coordinate
  // arrays; n is a multiple of 8.
  void evaluate(const double* local, const Vec3& centre, const double* points, Index n,
                double* field, double* gradient) const;

  // Number of doubles that evaluate_at() may read past the coefficients; their values have no
  // effect.
  static constexpr int beyond = 7;
  // Stores the coefficients of `local` in `rows`, in the order that evaluate_at() uses.
  void pack(const double* local, double* rows) const;
  // Computes the same as evaluate() at one point, except for rounding errors. `rows` contains the
  // coefficients from pack(), followed by at least `beyond` readable doubles.
  void evaluate_at(const double* rows, const Vec3& centre, const double* point, double* field,
                   double* gradient) const;

 private:
  void add_folded(double* all, double* moments) const;
  void shift_powers(const Vec3& shift, double* powers) const;

  TaylorTables tables_;
};

}  // namespace loomstone
