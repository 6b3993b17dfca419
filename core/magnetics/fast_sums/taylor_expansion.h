// Cartesian Taylor expansions of the potential of dipoles and charges: multipole moments M about a
// far point z, local coefficients L about a near point y, and their translations. With
// multi-indices n, m
//   phi(x) = sum_m M_m D_m(x - z),        D_m = d^m (1/r),                    far from z,
//          = sum_n L_n (x - y)^n / n!,    L_n = sum_m M_m D_{n+m}(y - z),     near y,
// truncated at |n| + |m| <= order for the two cells together. This truncation is symmetric in the
// two cells, so the forces between them are equal and opposite at any order [Dehnen2002]. Because
// 1/r is harmonic, moments M_{..z+2} can be folded into -M_{x+2..} and -M_{y+2..}, and L follows
// from its components with z <= 1: (order + 1)^2 numbers, as many as a spherical-harmonic expansion
// has.
#pragma once

#include "core/magnetics/fast_sums/taylor_tables.h"

namespace loomstone {

class TaylorExpansion {
 public:
  static constexpr int highest_order = TaylorTables::highest_order;

  explicit TaylorExpansion(int order) : tables_(order) {}  // 3 ... highest_order

  int order() const { return tables_.order; }
  int moments_size() const { return static_cast<int>(tables_.slim.size()); }  // z <= 1, by degree
  int local_size() const { return static_cast<int>(tables_.powers.size()); }  // all, by degree

  // Adds the moments of n dipoles about `centre`; positions and dipoles (n x 3).
  void add_dipoles(const double* positions, const double* dipoles, Index n, const Vec3& centre,
                   double* moments) const;
  // Adds the moments of n charges about `centre`; positions (n x 3).
  void add_charges(const double* positions, const double* charges, Index n, const Vec3& centre,
                   double* moments) const;
  // Adds the moments of a child cell (multipole-to-multipole); shift: from its centre to the new
  // one.
  void add_moments(const double* child, const Vec3& shift, double* moments) const;

  struct Far {
    const double* moments;
    double arm[3];  // from the far cell's centre to that of `local`
  };
  // Adds n far cells to a local expansion (multipole-to-local): the components with z <= 1, from
  // which complete() computes the others.
  void add_far(const Far* far, Index n, double* local) const;
  void complete(double* local) const;
  // Adds a complete expansion to the components with z <= 1 of another (local-to-local); shift:
  // from its centre to the new one.
  void add_local(const double* parent, const Vec3& shift, double* local) const;

  // -grad phi and its gradient (xx, xy, xz, yy, yz, zz) at n points by columns, n a multiple of 8.
  void evaluate(const double* local, const Vec3& centre, const double* points, Index n,
                double* field, double* gradient) const;

  // The same at one point, in a fifth of the time of a block of eight. rows: coefficients in the
  // order of pack(), followed by at least `beyond` readable doubles.
  static constexpr int beyond = 7;
  void pack(const double* local, double* rows) const;
  void evaluate_at(const double* rows, const Vec3& centre, const double* point, double* field,
                   double* gradient) const;

 private:
  void add_folded(double* all, double* moments) const;
  void shift_powers(const Vec3& shift, double* powers) const;

  TaylorTables tables_;
};

}  // namespace loomstone
