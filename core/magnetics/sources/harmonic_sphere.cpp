#include "core/magnetics/sources/harmonic_sphere.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "core/magnetics/sources/constants.h"
#include "core/magnetics/sources/gauss.h"
#include "core/magnetics/sources/lane_math.h"

namespace loomstone {

namespace {

using Complex = std::complex<double>;

constexpr int top = SphereSeries::most + 2;
std::size_t place(int l, int m) { return static_cast<std::size_t>(l) * (l + 1) / 2 + m; }

// Factors of the recurrence Y_lm = a z Y_(l-1)m - b Y_(l-2)m.
struct Recurrence {
  std::vector<double> a, b;
  Recurrence() : a(place(top + 1, 0)), b(place(top + 1, 0)) {
    for (int l = 1; l <= top; ++l) {
      for (int m = 0; m < l; ++m) {
        const double size = std::sqrt(static_cast<double>(l - m) * (l + m));
        a[place(l, m)] = (2.0 * l - 1.0) / size;
        b[place(l, m)] = std::sqrt(static_cast<double>(l - 1 - m) * (l - 1 + m)) / size;
      }
      a[place(l, l)] = std::sqrt((2.0 * l - 1.0) / (2.0 * l));  // times x + i y
    }
  }
};

const Recurrence& recurrence() {
  static const Recurrence table;
  return table;
}

// Coefficients of minus the derivative of sum Re(c S) along an axis, S the irregular harmonics in
// Schmidt's normalisation; degree: the highest of c.
std::vector<Complex> minus_derivative(const std::vector<Complex>& c, int degree, int axis) {
  const Complex i(0.0, 1.0);
  std::vector<Complex> d(place(degree + 2, 0));
  for (int l = 0; l <= degree; ++l) {
    for (int m = 0; m <= l; ++m) {
      const Complex value = c[place(l, m)];
      if (axis == 2) {
        d[place(l + 1, m)] += std::sqrt(static_cast<double>(l + 1 + m) * (l + 1 - m)) * value;
        continue;
      }
      const double up = std::sqrt(static_cast<double>(l + m + 2) * (l + m + 1));
      if (m == 0) {
        d[place(l + 1, 1)] += up * (axis == 0 ? value : -i * value);
        continue;
      }
      const double down = std::sqrt(static_cast<double>(l - m + 2) * (l - m + 1));
      d[place(l + 1, m + 1)] += 0.5 * up * (axis == 0 ? value : -i * value);
      d[place(l + 1, m - 1)] -= 0.5 * down * (axis == 0 ? value : i * value);
    }
    d[place(l + 1, 0)] = d[place(l + 1, 0)].real();
  }
  return d;
}

std::vector<double> flat(const std::vector<Complex>& c, double scale) {
  std::vector<double> out;
  for (const Complex& value : c) {
    out.push_back(scale * value.real());
    out.push_back(-scale * value.imag());  // Re(c S) = Re c Re S - Im c Im S
  }
  return out;
}

// Sums over the harmonics of degrees up to `highest`, as in multipole_expansion.cpp; points inside
// get the value on the surface.
template <int components, class Lanes>
LOOMSTONE_INLINE void evaluate(const double* const* coefficients, const double* factor_a,
                               const double* factor_b, double inverse_radius, const double* points,
                               Index n, int highest, double* out) {
  for (Index i = 0; i < n; i += n_lanes) {
    Lanes3<Lanes> p{lanes_load<Lanes>(points + i) * inverse_radius,
                    lanes_load<Lanes>(points + n + i) * inverse_radius,
                    lanes_load<Lanes>(points + 2 * n + i) * inverse_radius};
    const Lanes square = lanes_max(dot(p, p), lanes_all<Lanes>(1.0));
    const Lanes inverse = 1.0 / square, distance = lanes_sqrt(square);
    const Lanes needed = 39.0 / lanes_max(lanes_log(distance), lanes_all<Lanes>(1e-3)) + 3.0;
    int last = 0;
    for (int lane = 0; lane < n_lanes; ++lane)
      last = needed[lane] > last ? static_cast<int>(needed[lane]) + 1 : last;
    last = last < highest ? last : highest;
    Lanes sum[components];
    for (Lanes& s : sum) s = Lanes{};
    Lanes real[2][top + 1], imaginary[2][top + 1];  // degrees l and l - 1 in turn
    real[0][0] = lanes_sqrt(inverse);
    imaginary[0][0] = Lanes{};
    p.x *= inverse;
    p.y *= inverse;
    p.z *= inverse;
    for (int l = 1; l <= last; ++l) {
      Lanes* re = real[l & 1];
      Lanes* im = imaginary[l & 1];  // holds degree l - 2 on entry
      const Lanes* re1 = real[(l - 1) & 1];
      const Lanes* im1 = imaginary[(l - 1) & 1];
      const std::size_t row = static_cast<std::size_t>(l) * (l + 1) / 2;
      const double *fa = factor_a + row, *fb = factor_b + row;
      for (int m = 0; m <= l - 2; ++m) {
        const Lanes a = fa[m] * p.z, b = fb[m] * inverse;
        re[m] = a * re1[m] - b * re[m];
        im[m] = a * im1[m] - b * im[m];
      }
      re[l - 1] = fa[l - 1] * p.z * re1[l - 1];
      im[l - 1] = fa[l - 1] * p.z * im1[l - 1];
      re[l] = fa[l] * (p.x * re1[l - 1] - p.y * im1[l - 1]);
      im[l] = fa[l] * (p.x * im1[l - 1] + p.y * re1[l - 1]);
      const MaskOf<Lanes> wanted = needed > static_cast<double>(l);
      for (int c = 0; c < components; ++c) {
        const double* value = coefficients[c] + 2 * row;
        Lanes part{};
        for (int m = 0; m <= l; ++m) part += value[2 * m] * re[m] + value[2 * m + 1] * im[m];
        sum[c] += lanes_select(wanted, part, Lanes{});
      }
    }
    for (int c = 0; c < components; ++c) lanes_store(out + c * n + i, sum[c]);
  }
}

template <class Lanes>
LOOMSTONE_INLINE void field_kernel(const double* const* coefficients, const double* factor_a,
                                   const double* factor_b, double inverse_radius,
                                   const double* points, Index n, int highest, double* out) {
  evaluate<3, Lanes>(coefficients, factor_a, factor_b, inverse_radius, points, n, highest, out);
}

template <class Lanes>
LOOMSTONE_INLINE void gradient_kernel(const double* const* coefficients, const double* factor_a,
                                      const double* factor_b, double inverse_radius,
                                      const double* points, Index n, int highest, double* out) {
  evaluate<6, Lanes>(coefficients, factor_a, factor_b, inverse_radius, points, n, highest, out);
}

}  // namespace

SphereSeries::SphereSeries(int degree) : degree_(degree), turns_(2 * degree + 2) {
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

void SphereSeries::legendre(int ring, std::vector<double>& p) const {
  const Recurrence& table = recurrence();
  const double z = cosines_[ring], sine = std::sqrt((1.0 - z) * (1.0 + z));
  p.assign(place(degree_ + 1, 0), 0.0);
  p[0] = 1.0;
  for (int l = 1; l <= degree_; ++l) {
    for (int m = 0; m < l; ++m)
      p[place(l, m)] = table.a[place(l, m)] * z * p[place(l - 1, m)] -
                       (m < l - 1 ? table.b[place(l, m)] * p[place(l - 2, m)] : 0.0);
    p[place(l, l)] = table.a[place(l, l)] * sine * p[place(l - 1, l - 1)];
  }
}

Vector SphereSeries::coefficients(const Vector& values) const {
  const Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>
      rings(values.data(), cosines_.size(), turns_);
  const Eigen::MatrixXd real = rings * waves_, imaginary = rings * sines_;
  Vector result = Vector::Zero(size());
  std::vector<double> p;
  for (Index ring = 0; ring < cosines_.size(); ++ring) {
    legendre(ring, p);
    const double weight =
        weights_[ring] / turns_;  // of the mean over the sphere, twice, as is right for m > 0
    for (int l = 1; l <= degree_; ++l) {
      result[slot(l, 0)] += 0.5 * (2.0 * l + 1.0) * weight * p[place(l, 0)] * real(ring, 0);
      for (int m = 1; m <= l; ++m) {
        const double factor = (2.0 * l + 1.0) * weight * p[place(l, m)];
        result[slot(l, m)] += factor * real(ring, m);
        result[slot(l, m) + 1] -= factor * imaginary(ring, m);
      }
    }
  }
  return result;
}

Vector SphereSeries::values(const Vector& coefficients) const {
  Eigen::MatrixXd real = Eigen::MatrixXd::Zero(cosines_.size(), degree_ + 1), imaginary = real;
  std::vector<double> p;
  for (Index ring = 0; ring < cosines_.size(); ++ring) {
    legendre(ring, p);
    for (int l = 1; l <= degree_; ++l)
      for (int m = 0; m <= l; ++m) {
        real(ring, m) += p[place(l, m)] * coefficients[slot(l, m)];
        imaginary(ring, m) += p[place(l, m)] * coefficients[slot(l, m) + 1];
      }
  }
  const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> rings =
      real * waves_.transpose() - imaginary * sines_.transpose();
  return Eigen::Map<const Vector>(rings.data(), rings.size());
}

HarmonicSphere::HarmonicSphere(double radius, std::shared_ptr<const SphereSeries> series,
                               Vector coefficients)
    : radius_(radius), series_(std::move(series)), coefficients_(std::move(coefficients)) {
  const int degree = series_->degree();
  std::vector<Complex> c(place(degree + 1, 0));
  for (int l = 1; l <= degree; ++l)
    for (int m = 0; m <= l; ++m) {
      const Index k = SphereSeries::slot(l, m);
      c[place(l, m)] = Complex(coefficients_[k], m > 0 ? coefficients_[k + 1] : 0.0);
    }
  int k = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<Complex> first = minus_derivative(c, degree, axis);
    field_[axis] = flat(first, 1.0);
    for (int second = axis; second < 3; ++second)
      gradient_[k++] = flat(minus_derivative(first, degree + 1, second), -1.0 / radius_);
  }
}

void HarmonicSphere::field_block(const double* points, Index n, Quantity quantity,
                                 double* field) const {
  const double* coefficients[3] = {field_[0].data(), field_[1].data(), field_[2].data()};
  LOOMSTONE_WIDEST(field_kernel)(coefficients, recurrence().a.data(), recurrence().b.data(),
                                 1.0 / radius_, points, n, series_->degree() + 1, field);
  for (Index i = 0; i < n; ++i) {
    const Vec3 point(points[i], points[n + i], points[2 * n + i]);
    if (point.norm() >= radius_ * (1.0 - 1e-12)) continue;
    const Vec3 value = inside(point / radius_, quantity);
    for (int c = 0; c < 3; ++c) field[c * n + i] = value[c];
  }
}

void HarmonicSphere::gradient_block(const double* points, Index n, double* gradient) const {
  const double* coefficients[6];
  for (int c = 0; c < 6; ++c) coefficients[c] = gradient_[c].data();
  LOOMSTONE_WIDEST(gradient_kernel)(coefficients, recurrence().a.data(), recurrence().b.data(),
                                    1.0 / radius_, points, n, series_->degree() + 2, gradient);
  for (Index i = 0; i < n; ++i) {
    if (std::hypot(points[i], points[n + i], points[2 * n + i]) >= radius_ * (1.0 - 1e-12))
      continue;
    for (int c = 0; c < 6; ++c) gradient[c * n + i] = 0.0;
  }
}

// The charge's own potential goes on inside with the same coefficients; the magnetisation is the
// gradient of a harmonic function whose normal derivative is the charge.
Vec3 HarmonicSphere::inside(const Vec3& x, Quantity quantity) const {
  const Recurrence& table = recurrence();
  const int degree = series_->degree();
  std::vector<Complex> r(place(degree + 1, 0));
  r[0] = 1.0;
  Vec3 field = Vec3::Zero();
  for (int l = 1; l <= degree; ++l) {
    for (int m = 0; m < l; ++m)
      r[place(l, m)] =
          table.a[place(l, m)] * x.z() * r[place(l - 1, m)] -
          (m < l - 1 ? table.b[place(l, m)] * x.squaredNorm() * r[place(l - 2, m)] : 0.0);
    r[place(l, l)] = table.a[place(l, l)] * Complex(x.x(), x.y()) * r[place(l - 1, l - 1)];
    const double share = quantity == Quantity::flux_density ? -(l + 1.0) / l : 1.0;
    for (int m = 0; m <= l; ++m) {
      const Index k = SphereSeries::slot(l, m);
      const Complex c(coefficients_[k], m > 0 ? coefficients_[k + 1] : 0.0);
      // Derivatives along x + i y, x - i y and z.
      const Complex plus = m + 1 <= l - 1 ? -std::sqrt(static_cast<double>(l - m) * (l - m - 1)) *
                                                r[place(l - 1, m + 1)]
                                          : 0.0;
      const Complex minus =
          m == 0 ? std::conj(plus)
                 : std::sqrt(static_cast<double>(l + m) * (l + m - 1)) * r[place(l - 1, m - 1)];
      const Complex up =
          m <= l - 1 ? std::sqrt(static_cast<double>(l - m) * (l + m)) * r[place(l - 1, m)] : 0.0;
      field -= share * Vec3((c * 0.5 * (plus + minus)).real(),
                            (c * Complex(0.0, -0.5) * (plus - minus)).real(), (c * up).real());
    }
  }
  return field;
}

Vec3 HarmonicSphere::moment() const {
  const Index k = SphereSeries::slot(1, 1);
  return 4.0 * pi * radius_ * radius_ * radius_ / mu0 *
         Vec3(coefficients_[k] / std::sqrt(2.0), -coefficients_[k + 1] / std::sqrt(2.0),
              coefficients_[SphereSeries::slot(1, 0)]);
}

std::vector<PanelSample> HarmonicSphere::charges() const {
  Vector density(coefficients_.size());
  for (int l = 1; l <= series_->degree(); ++l) {
    const Index from = SphereSeries::slot(l, 0), n = 2 * (l + 1);
    density.segment(from, n) = (2.0 * l + 1.0) / mu0 * coefficients_.segment(from, n);
  }
  const Vector values = series_->values(density);
  std::vector<PanelSample> result(values.size());
  for (std::size_t i = 0; i < result.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const Vec3 normal = series_->points().row(row).transpose();
    result[i].position = radius_ * normal;
    result[i].area = 4.0 * pi * radius_ * radius_ * series_->shares()[row] * normal;
    result[i].charge = 4.0 * pi * radius_ * radius_ * series_->shares()[row] * values[row];
  }
  return result;
}

// With S and R the unnormalised harmonics of multipole_expansion.h, S_lm(r - d) = (-1)^(l+m) sum
// over n of (n+l)! / d^(n+l+1) R_nm for d along +z; below the target (-1)^(n+m) stands for
// (-1)^(l+m).
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
        real += *factor * source[SphereSeries::slot(l, m)];
        imaginary += *factor * source[SphereSeries::slot(l, m) + 1];
      }
      target[SphereSeries::slot(n, m)] += real;
      target[SphereSeries::slot(n, m) + 1] += imaginary;
    }
  }
}

}  // namespace loomstone
