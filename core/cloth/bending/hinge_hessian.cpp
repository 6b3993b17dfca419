#include "core/cloth/bending/hinge_hessian.h"

#include <array>

namespace loomstone {

namespace {

// theta is the difference of the direction angles phi of the two triangles about the edge x3 -> x4.
// Let b be the unit vector along the edge, and L the edge length. Relative to x3, the apex of a
// triangle is a = alpha b + eta t with a unit vector t normal to the edge. With n = b x t and
// S = n t^T + t n^T, the second derivatives of phi with respect to a and the edge vector e are
//   phi_aa = -S / eta^2,   phi_ae = alpha / (L eta^2) S - b n^T / (L eta),
//   phi_ee = -S (1/2 + alpha^2 / eta^2) / L^2 + alpha / (L^2 eta) (n b^T + b n^T).
// The antisymmetric part of phi_ee is left out, because it is the same for both triangles and
// cancels in their difference.
struct Direction {
  Mat3 aa, ae, ee;
};

bool second_derivative(const Vec3& a, const Vec3& e, Direction& d) {
  const double length = e.norm();
  if (!(length > 0.0)) return false;
  const Vec3 along = e / length;
  const double alpha = a.dot(along);
  Vec3 t = a - alpha * along;
  const double eta = t.norm();
  if (!(eta > 1e-12 * a.norm())) return false;  // hinge::angles has the same threshold
  t /= eta;
  const Vec3 n = along.cross(t);
  const Mat3 s = n * t.transpose() + t * n.transpose(), mixed = along * n.transpose();
  d.aa = -s / (eta * eta);
  d.ae = alpha / (length * eta * eta) * s - mixed / (length * eta);
  d.ee = -(0.5 + alpha * alpha / (eta * eta)) / (length * length) * s +
         alpha / (length * length * eta) * (mixed + mixed.transpose());
  return true;
}

// Computes blocks (row, j) of the Hessian of theta for the four vertices j. Returns false if a
// triangle has zero area.
bool hessian_row(const std::array<Index, 4>& vertices, int row, const Points& x,
                 std::array<Mat3, 4>& blocks) {
  const auto from_x3 = [&](int j) {
    return Vec3((x.row(vertices[j]) - x.row(vertices[2])).transpose());
  };
  Direction a, c;
  const Vec3 e = from_x3(3);
  if (!second_derivative(from_x3(0), e, a) || !second_derivative(from_x3(1), e, c)) return false;
  const Mat3 zero = Mat3::Zero();
  // Blocks for (x1, x2, x4). The block for x3 follows because the blocks of a row sum to zero.
  std::array<Mat3, 3> r;
  if (row == 0)
    r = {a.aa, zero, a.ae};
  else if (row == 1)
    r = {zero, -c.aa, -c.ae};
  else if (row == 3)
    r = {a.ae.transpose(), -c.ae.transpose(), a.ee - c.ee};
  else
    r = {-(a.aa + a.ae.transpose()), c.aa + c.ae.transpose(), c.ae - a.ae - a.ee + c.ee};
  blocks = {r[0], r[1], Mat3(-(r[0] + r[1] + r[2])), r[2]};
  return true;
}

}  // namespace

void add_hinge_hessians(const Team& team, const HingeMoments& moments, const Points& x, Index begin,
                        Index end, BlockMatrix& matrix) {
  const Incidence& incidence = moments.hinges.of_vertices();
  parallel_for(team, end - begin, [&](Index i) {
    const Index row = begin + i;
    std::array<Mat3, 4> blocks;
    for (Index k = incidence.start[row]; k < incidence.start[row + 1]; ++k) {
      const Index item = incidence.items[k], hinge = item / 4;
      const auto& vertices = moments.hinges.hinges()[hinge].vertices;
      if (!hessian_row(vertices, static_cast<int>(item % 4), x, blocks)) continue;
      for (int j = 0; j < 4; ++j)
        matrix.block_map(matrix.find(row, vertices[j])) +=
            moments.scale * moments.moment[hinge] * blocks[j];
    }
  });
}

}  // namespace loomstone
