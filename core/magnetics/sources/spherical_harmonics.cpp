#include "core/magnetics/sources/spherical_harmonics.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "core/magnetics/sources/constants.h"
#include "core/magnetics/sources/gauss.h"

namespace loomstone {

namespace {

constexpr int top = SphericalHarmonics::most + 2;

HarmonicRecurrence make_recurrence() {
  HarmonicRecurrence table;
  table.a.resize(triangle_place(top + 1, 0));
  table.b.resize(triangle_place(top + 1, 0));
  for (int l = 1; l <= top; ++l) {
    for (int m = 0; m < l; ++m) {
      const double size = std::sqrt(static_cast<double>(l - m) * (l + m));
      table.a[triangle_place(l, m)] = (2.0 * l - 1.0) / size;
      table.b[triangle_place(l, m)] =
          std::sqrt(static_cast<double>(l - 1 - m) * (l - 1 + m)) / size;
    }
    table.a[triangle_place(l, l)] = std::sqrt((2.0 * l - 1.0) / (2.0 * l));  // multiplies x + i y
  }
  return table;
}

}  // namespace

const HarmonicRecurrence& harmonic_recurrence() {
  static const HarmonicRecurrence table = make_recurrence();
  return table;
}

SphericalHarmonics::SphericalHarmonics(int degree) : degree_(degree), turns_(2 * degree + 2) {
  const int rings = degree + 1;
  cosines_.resize(rings);
  weights_.resize(rings);
  gauss_points(rings, cosines_.data(), weights_.data());
  points_.resize(rings * turns_, 3);
  shares_.resize(rings * turns_);
  waves_.resize(turns_, degree + 1);
  sines_.resize(turns_, degree + 1);
  for (int k = 0; k < turns_; ++k)
    for (int m = 0; m <= degree; ++m) {
      const double angle = 2.0 * pi * (static_cast<std::ptrdiff_t>(m) * k % turns_) / turns_;
      waves_(k, m) = std::cos(angle);
      sines_(k, m) = std::sin(angle);
    }
  for (int ring = 0; ring < rings; ++ring) {
    const double sine = std::sqrt((1.0 - cosines_[ring]) * (1.0 + cosines_[ring]));
    for (int k = 0; k < turns_; ++k) {
      const double phi = 2.0 * pi * k / turns_;
      points_.row(ring * turns_ + k) << sine * std::cos(phi), sine * std::sin(phi), cosines_[ring];
      shares_[ring * turns_ + k] = 0.5 * weights_[ring] / turns_;
    }
  }
}

void SphericalHarmonics::legendre(int ring, std::vector<double>& p) const {
  const HarmonicRecurrence& table = harmonic_recurrence();
  const double z = cosines_[ring], sine = std::sqrt((1.0 - z) * (1.0 + z));
  p.assign(triangle_place(degree_ + 1, 0), 0.0);
  p[0] = 1.0;
  for (int l = 1; l <= degree_; ++l) {
    for (int m = 0; m < l; ++m)
      p[triangle_place(l, m)] =
          table.a[triangle_place(l, m)] * z * p[triangle_place(l - 1, m)] -
          (m < l - 1 ? table.b[triangle_place(l, m)] * p[triangle_place(l - 2, m)] : 0.0);
    p[triangle_place(l, l)] =
        table.a[triangle_place(l, l)] * sine * p[triangle_place(l - 1, l - 1)];
  }
}

Vector SphericalHarmonics::coefficients(const Vector& values) const {
  const Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>
      rings(values.data(), cosines_.size(), turns_);
  const Eigen::MatrixXd real = rings * waves_, imaginary = rings * sines_;
  Vector result = Vector::Zero(size());
  std::vector<double> p;
  for (Index ring = 0; ring < cosines_.size(); ++ring) {
    legendre(ring, p);
    // `weight` is twice the fraction of the sphere's area that a point represents. Coefficients
    // with m > 0 need the factor 2; those with m = 0 are halved below.
    const double weight = weights_[ring] / turns_;
    for (int l = 1; l <= degree_; ++l) {
      result[slot(l, 0)] +=
          0.5 * (2.0 * l + 1.0) * weight * p[triangle_place(l, 0)] * real(ring, 0);
      for (int m = 1; m <= l; ++m) {
        const double factor = (2.0 * l + 1.0) * weight * p[triangle_place(l, m)];
        result[slot(l, m)] += factor * real(ring, m);
        result[slot(l, m) + 1] -= factor * imaginary(ring, m);
      }
    }
  }
  return result;
}

Vector SphericalHarmonics::values(const Vector& coefficients) const {
  Eigen::MatrixXd real = Eigen::MatrixXd::Zero(cosines_.size(), degree_ + 1), imaginary = real;
  std::vector<double> p;
  for (Index ring = 0; ring < cosines_.size(); ++ring) {
    legendre(ring, p);
    for (int l = 1; l <= degree_; ++l)
      for (int m = 0; m <= l; ++m) {
        real(ring, m) += p[triangle_place(l, m)] * coefficients[slot(l, m)];
        imaginary(ring, m) += p[triangle_place(l, m)] * coefficients[slot(l, m) + 1];
      }
  }
  const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> rings =
      real * waves_.transpose() - imaginary * sines_.transpose();
  return Eigen::Map<const Vector>(rings.data(), rings.size());
}

// With the unnormalised harmonics S (multipole_expansion.h) and R (multipole_expansion.cpp) and a
// vector d along +z,
//   S_lm(r - d) = (-1)^(l+m) sum over n of (n+l)! / |d|^(n+l+1) R_nm(r).
// For d along -z, (-1)^(n+m) replaces (-1)^(l+m).
CoaxialTranslation::CoaxialTranslation(double height, int source_degree, double source_radius,
                                       int target_degree, double target_radius)
    : source_degree_(source_degree), target_degree_(target_degree) {
  const double distance = std::abs(height), a = source_radius / distance,
               b = target_radius / distance;
  std::vector<double> log_factorial(source_degree + target_degree + 1, 0.0);
  for (std::size_t i = 1; i < log_factorial.size(); ++i)
    log_factorial[i] = log_factorial[i - 1] + std::log(double(i));
  const auto& f = log_factorial;
  for (int m = 0; m <= std::min(source_degree, target_degree); ++m) {
    for (int n = std::max(m, 1); n <= target_degree; ++n) {
      for (int l = std::max(m, 1); l <= source_degree; ++l) {
        const double size = f[n + l] - 0.5 * (f[l + m] + f[l - m] + f[n + m] + f[n - m]);
        const double sign = ((height > 0.0 ? l : n) + m) % 2 == 0 ? 1.0 : -1.0;
        factors_.push_back(sign * source_radius / target_radius *
                           std::exp(size + (l + 1) * std::log(a) + n * std::log(b)));
      }
    }
  }
}

void CoaxialTranslation::add(const Vector& source, Vector& target) const {
  const double* factor = factors_.data();
  for (int m = 0; m <= std::min(source_degree_, target_degree_); ++m) {
    for (int n = std::max(m, 1); n <= target_degree_; ++n) {
      double real = 0.0, imaginary = 0.0;
      for (int l = std::max(m, 1); l <= source_degree_; ++l, ++factor) {
        real += *factor * source[SphericalHarmonics::slot(l, m)];
        imaginary += *factor * source[SphericalHarmonics::slot(l, m) + 1];
      }
      target[SphericalHarmonics::slot(n, m)] += real;
      target[SphericalHarmonics::slot(n, m) + 1] += imaginary;
    }
  }
}

}  // namespace loomstone
