// The arithmetic of hinges and of mid-edge triangles on batches of eight.
#pragma once

#include <cstdint>

#include "core/base/types.h"

namespace loomstone::hinge {

// Entries a batch takes in each table.
inline constexpr int vertex_stride = 4 * 8, angle_stride = 8;
inline constexpr int gradient_stride = 16;  // of one hinge: 4 vertices of 3 components and a zero

// Where angles() writes; each table has an entry for every batch.
struct Output {
  double*
      difference;     // (batches x 8) theta minus rest angle; 0 where the hinge is degenerate [rad]
  double* half_sine;  // (batches x 8) sin(theta / 2)
  double* half_cosine;  // (batches x 8) cos(theta / 2) >= 0
  double* rate;         // (batches x 8) d theta / dt; null: not wanted [rad/s]
  double* gradient;     // (batches x 8 x 4 x 4) u = d theta / d x; null: not wanted; 0 where
                        // degenerate [rad/m]
};

// Angle in [-pi, pi] and gradient of each hinge (method.md 1.2) of the batches listed.
// vertices (batches x 4 x 8); rest (batches x 8) rest angles.
void angles(const Index* vertices, const double* rest, const Index* batches, Index n,
            const double* x, const double* v, const Output& out);

// sums (n_sums x 4) = for each row the sum over the n hinges listed of moment times gradient;
// places (n x 4): the row of each vertex.
void add_moments(const Index* hinges, const std::uint8_t* places, Index n, const double* moment,
                 const double* gradient, Index n_sums, double* sums);

}  // namespace loomstone::hinge

namespace loomstone::midedge {

inline constexpr int n_slots =
    9;  // hinges whose angle enters the curvature of one triangle, at most
inline constexpr int hinge_stride = n_slots * 8, curvature_stride = 3 * n_slots * 8,
                     rigidity_stride = 7 * 8;

// Constant tables of all batches of triangles.
struct Tables {
  const Index* hinges;      // (batches x 9 x 8)
  const double* curvature;  // (batches x 9 x 3 x 8) C: curvature per angle [1/m]
  const double* rigidity;   // (batches x 7 x 8) W = area times condensed D: 00 01 02 11 12 22 [N
                            // m^3]; damping beta [s]
};

// moments (batches x 9 x 8): C^T W C (difference + beta rate) of each triangle [N m]; rate may be
// null.
void moments(const Tables& tables, const Index* batches, Index n, const double* difference,
             const double* rate, double* out);

// energies (batches x 8): half C^T W C difference^2 [J].
void energies(const Tables& tables, const Index* batches, Index n, const double* difference,
              double* out);

}  // namespace loomstone::midedge
