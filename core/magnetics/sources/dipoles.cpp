// Sums over dipoles. Each SIMD lane sums over all dipoles in the same order for one observer, so
// the result does not depend on the number of threads.
#include "core/magnetics/sources/dipoles.h"

#include <algorithm>
#include <cmath>

#include "core/base/message.h"
#include "core/magnetics/sources/constants.h"
#include "core/magnetics/sources/dipole_terms.h"

namespace loomstone {

namespace {

constexpr double k = mu0 / (4.0 * pi);

template <class Lanes>
LOOMSTONE_INLINE void field_kernel(DipoleTable by, const double* points, Index n, double* out) {
  for (Index i = 0; i < n; i += n_lanes) {
    const Lanes3<Lanes> p = lanes3_load<Lanes>(points + i, n);
    Lanes3<Lanes> sum{};
    for (Index j = 0; j < by.n; ++j) {
      const double* m = by.moments + 3 * j;
      const DipoleArm<Lanes> a = dipole_arm(p, by.positions + 3 * j);
      add_dipole_field(m, a, m[0] * a.r.x + m[1] * a.r.y + m[2] * a.r.z, sum);
    }
    lanes_store(out + i, k * sum.x);
    lanes_store(out + n + i, k * sum.y);
    lanes_store(out + 2 * n + i, k * sum.z);
  }
}

template <class Lanes>
LOOMSTONE_INLINE void potential_kernel(DipoleTable by, const double* points, Index n, double* out) {
  for (Index i = 0; i < n; i += n_lanes) {
    const Lanes3<Lanes> p = lanes3_load<Lanes>(points + i, n);
    Lanes sum{};
    for (Index j = 0; j < by.n; ++j) {
      const double* m = by.moments + 3 * j;
      const DipoleArm<Lanes> a = dipole_arm(p, by.positions + 3 * j);
      sum += (m[0] * a.r.x + m[1] * a.r.y + m[2] * a.r.z) * a.inverse3;
    }
    lanes_store(out + i, k * sum);
  }
}

template <class Lanes>
LOOMSTONE_INLINE void gradient_kernel(DipoleTable by, const double* points, Index n, double* out) {
  for (Index i = 0; i < n; i += n_lanes) {
    const Lanes3<Lanes> p = lanes3_load<Lanes>(points + i, n);
    Lanes sum[6];
    for (Lanes& s : sum) s = Lanes{};
    for (Index j = 0; j < by.n; ++j) {
      const double* m = by.moments + 3 * j;
      const DipoleArm<Lanes> a = dipole_arm(p, by.positions + 3 * j);
      const Lanes mr = m[0] * a.r.x + m[1] * a.r.y + m[2] * a.r.z;
      add_dipole_gradient(m, a, mr, sum);
    }
    for (int c = 0; c < 6; ++c) lanes_store(out + c * n + i, 3.0 * k * sum[c]);
  }
}

template <class Lanes>
LOOMSTONE_INLINE void field_and_gradient_kernel(DipoleTable by, const double* points, Index n,
                                                double* field, double* gradient) {
  for (Index i = 0; i < n; i += n_lanes) {
    const Lanes3<Lanes> p = lanes3_load<Lanes>(points + i, n);
    Lanes3<Lanes> b{};
    Lanes sum[6];
    for (Lanes& s : sum) s = Lanes{};
    for (Index j = 0; j < by.n; ++j) {
      const double* m = by.moments + 3 * j;
      const DipoleArm<Lanes> a = dipole_arm(p, by.positions + 3 * j);
      const Lanes mr = m[0] * a.r.x + m[1] * a.r.y + m[2] * a.r.z;
      add_dipole_field(m, a, mr, b);
      add_dipole_gradient(m, a, mr, sum);
    }
    lanes_store(field + i, k * b.x);
    lanes_store(field + n + i, k * b.y);
    lanes_store(field + 2 * n + i, k * b.z);
    for (int c = 0; c < 6; ++c) lanes_store(gradient + c * n + i, 3.0 * k * sum[c]);
  }
}

// Computes the field (6.5) and the force (6.10) of [Thomaszewski2010].
template <class Lanes>
LOOMSTONE_INLINE void force_kernel(DipoleTable by, DipoleColumns on, double nearest2, double* field,
                                   double* force) {
  const Index n = on.n;
  for (Index i = 0; i < n; i += n_lanes) {
    const Lanes3<Lanes> p = lanes3_load<Lanes>(on.points + i, n);
    const Lanes3<Lanes> q = lanes3_load<Lanes>(on.moments + i, n);
    Lanes3<Lanes> b{}, f = b;
    for (Index j = 0; j < by.n; ++j) {
      const double* m = by.moments + 3 * j;
      const DipoleArm<Lanes> a = dipole_arm(p, by.positions + 3 * j, nearest2);
      const Lanes mr = m[0] * a.r.x + m[1] * a.r.y + m[2] * a.r.z;
      add_dipole_field(m, a, mr, b);
      const Lanes qr = q.x * a.r.x + q.y * a.r.y + q.z * a.r.z;
      const Lanes qm = q.x * m[0] + q.y * m[1] + q.z * m[2];
      const Lanes scale = a.inverse3 * a.inverse2;
      const Lanes radial = qm - 5.0 * mr * qr * a.inverse2;
      f.x += (radial * a.r.x + mr * q.x + qr * m[0]) * scale;
      f.y += (radial * a.r.y + mr * q.y + qr * m[1]) * scale;
      f.z += (radial * a.r.z + mr * q.z + qr * m[2]) * scale;
    }
    lanes_store(field + i, k * b.x);
    lanes_store(field + n + i, k * b.y);
    lanes_store(field + 2 * n + i, k * b.z);
    lanes_store(force + i, 3.0 * k * f.x);
    lanes_store(force + n + i, 3.0 * k * f.y);
    lanes_store(force + 2 * n + i, 3.0 * k * f.z);
  }
}

}  // namespace

void dipole_field_block(const DipoleTable& by, const double* points, Index n, double* field) {
  LOOMSTONE_WIDEST(field_kernel)(by, points, n, field);
}

void dipole_gradient_block(const DipoleTable& by, const double* points, Index n, double* gradient) {
  LOOMSTONE_WIDEST(gradient_kernel)(by, points, n, gradient);
}

void dipole_force_block(const DipoleTable& by, const DipoleColumns& on, double nearest2,
                        double* field, double* force) {
  LOOMSTONE_WIDEST(force_kernel)(by, on, nearest2, field, force);
}

DipoleSet::DipoleSet(Points positions, Points moments)
    : positions_(std::move(positions)), moments_(std::move(moments)) {
  check_points(positions_, "points");
  if (moments_.rows() != positions_.rows())
    fail<InvalidInput>("moments must have a row for each of the {} points, got {}",
                       positions_.rows(), moments_.rows());
  for (Eigen::Index i = 0; i < moments_.rows(); ++i)
    if (!moments_.row(i).allFinite())
      fail<InvalidInput>("moments must be finite [A m^2], but row {} is not", i);
}

void DipoleSet::field_block(const double* points, Index n, Quantity, double* field) const {
  LOOMSTONE_WIDEST(field_kernel)(table(), points, n, field);
}

void DipoleSet::gradient_block(const double* points, Index n, double* gradient) const {
  LOOMSTONE_WIDEST(gradient_kernel)(table(), points, n, gradient);
}

void DipoleSet::field_and_gradient_block(const double* points, Index n, Quantity, double* field,
                                         double* gradient) const {
  LOOMSTONE_WIDEST(field_and_gradient_kernel)(table(), points, n, field, gradient);
}

void DipoleSet::potential_block(const double* points, Index n, double* potential) const {
  LOOMSTONE_WIDEST(potential_kernel)(table(), points, n, potential);
}

double DipoleSet::radius() const {
  return positions_.rows() > 0 ? positions_.rowwise().norm().maxCoeff() : 0.0;
}

Wrenches dipole_forces(const Team& team, const Points& positions, const Points& moments,
                       const DipoleSet& by, double nearest) {
  const Index n = static_cast<Index>(positions.rows());
  Wrenches result{Points(n, 3), Points(n, 3), Vector(n)};
  const Index blocks = (n + points_per_block - 1) / points_per_block;
  parallel_for(
      team, blocks,
      [&](Index block) {
        const Index begin = block * points_per_block, end = std::min(n, begin + points_per_block);
        const Index padded = (end - begin + n_lanes - 1) / n_lanes * n_lanes;
        alignas(64) double x[3 * points_per_block], m[3 * points_per_block],
            b[3 * points_per_block], f[3 * points_per_block];
        for (Index i = 0; i < padded; ++i) {
          const Index row = std::min(begin + i, end - 1);
          for (int c = 0; c < 3; ++c) {
            x[c * padded + i] = positions(row, c);
            m[c * padded + i] = moments(row, c);
          }
        }
        LOOMSTONE_WIDEST(force_kernel)(by.table(), DipoleColumns{x, m, padded}, nearest * nearest,
                                       b, f);
        for (Index i = begin; i < end; ++i) {
          const Index j = i - begin;
          const Vec3 field(b[j], b[padded + j], b[2 * padded + j]),
              own = moments.row(i).transpose();
          result.forces.row(i) = Vec3(f[j], f[padded + j], f[2 * padded + j]).transpose();
          result.torques.row(i) = own.cross(field).transpose();  // (6.11) of [Thomaszewski2010]
          result.energies[i] = -own.dot(field);
        }
      },
      1);
  return result;
}

double dipole_energy(const Team& team, const DipoleSet& set) {
  const Wrenches pairs = dipole_forces(team, set.positions(), set.moments(), set);
  return 0.5 * parallel_sum(team, static_cast<Index>(set.positions().rows()),
                            [&](Index i) { return pairs.energies[i]; });
}

}  // namespace loomstone
