// SIMD kernels for hinges and mid-edge triangles, in batches of eight.
#pragma once

#include <cstdint>

#include "core/base/types.h"

namespace loomstone::hinge {

inline constexpr Index batches_per_range = 32;  // grain size of parallel loops

// Entries per batch in each table; for gradients, entries per hinge.
inline constexpr int vertex_stride = 4 * 8, angle_stride = 8;
inline constexpr int gradient_stride = 16;  // per hinge: 4 vertices x (3 components and a zero)

// Constant tables of all batches.
struct Tables {
  const Index* vertices;  // (batches x 4 x 8) vertices of hinges
  const double* rest;     // (batches x 8) rest angles [rad]
};

// Output tables of angles(), with entries for all batches. Hinges with a zero-area triangle get
// zero difference and zero gradient.
struct Output {
  double* difference;   // (batches x 8) theta minus rest angle [rad]
  double* half_sine;    // (batches x 8) sin(theta / 2)
  double* half_cosine;  // (batches x 8) cos(theta / 2) >= 0
  double* rate;         // (batches x 8) d theta / dt [rad/s]; null: not computed
  double* gradient;     // (batches x 8 x 4 x 4) u = d theta / d x [rad/m]; null: not computed
};

// Computes the entries of `out` for each hinge of the n listed batches. The angles lie in
// [-pi, pi], and their gradients are those of [Bridson2003]. Rates require v and out.gradient.
void angles(Tables tables, const Index* batches, Index n, const double* x, const double* v,
            const Output& out);

// A list of hinges. For each vertex of each hinge, `places` contains the row of `sums` in
// add_moments() to which the hinge contributes.
struct HingeList {
  const Index* hinges;         // (n)
  const std::uint8_t* places;  // (n x 4)
  Index n;
};

// Sets each row of `sums` (n_sums x 4) to the sum of moment times gradient over the hinge vertices
// that `places` assigns to this row. `moment` has one entry per hinge.
void add_moments(HingeList list, const double* moment, const double* gradient, Index n_sums,
                 double* sums);

}  // namespace loomstone::hinge

namespace loomstone::midedge {

// Largest number of hinges on which the curvature of a triangle depends.
inline constexpr int n_slots = 9;
inline constexpr int hinge_stride = n_slots * 8, curvature_stride = 3 * n_slots * 8,
                     rigidity_stride = 7 * 8;

// Constant tables of all batches of triangles.
struct Tables {
  const Index* hinges;      // (batches x 9 x 8) hinges of triangles
  const double* curvature;  // (batches x 9 x 3 x 8) C, the curvature per hinge angle [1/m]
  // (batches x 7 x 8) Entries 00 01 02 11 12 22 of the matrix W [N m^3], followed by the damping
  // time beta [s]. W is Element::rigidity (midedge_setup.h), the rest area times the condensed
  // rigidity.
  const double* rigidity;
};

// Computes, for each triangle in the n given `batches`, the moments
//   C^T W C (difference + beta rate) [N m].
// `out` (batches x 9 x 8) has room for all batches. C, W and beta are those of Tables.
// `difference` and `rate` are those of hinge::Output. If `rate` is null, it counts as 0.
void moments(const Tables& tables, const Index* batches, Index n, const double* difference,
             const double* rate, double* out);

// Computes, for each triangle in the n given `batches`, the energy
//   1/2 difference^T C^T W C difference [J]
// with the symbols of moments(). `out` (batches x 8) has room for all batches.
void energies(const Tables& tables, const Index* batches, Index n, const double* difference,
              double* out);

}  // namespace loomstone::midedge
