#include "core/magnetics/sources/harmonic_sphere.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdlib>

#include "core/magnetics/sources/constants.h"
#include "core/magnetics/sources/lane_math.h"

namespace loomstone {

namespace {

using Complex = std::complex<double>;

constexpr int top = SphericalHarmonics::most + 2;

// Returns the coefficients of minus the derivative of sum Re(c S) along an axis, where S are the
// irregular harmonics in Schmidt semi-normalisation. `degree` is the highest degree in c.
std::vector<Complex> minus_derivative(const std::vector<Complex>& c, int degree, int axis) {
  const Complex i(0.0, 1.0);
  std::vector<Complex> d(triangle_place(degree + 2, 0));
  for (int l = 0; l <= degree; ++l) {
    for (int m = 0; m <= l; ++m) {
      const Complex value = c[triangle_place(l, m)];
      if (axis == 2) {
        d[triangle_place(l + 1, m)] +=
            std::sqrt(static_cast<double>(l + 1 + m) * (l + 1 - m)) * value;
        continue;
      }
      const double up = std::sqrt(static_cast<double>(l + m + 2) * (l + m + 1));
      if (m == 0) {
        d[triangle_place(l + 1, 1)] += up * (axis == 0 ? value : -i * value);
        continue;
      }
      const double down = std::sqrt(static_cast<double>(l - m + 2) * (l - m + 1));
      d[triangle_place(l + 1, m + 1)] += 0.5 * up * (axis == 0 ? value : -i * value);
      d[triangle_place(l + 1, m - 1)] -= 0.5 * down * (axis == 0 ? value : i * value);
    }
    d[triangle_place(l + 1, 0)] = d[triangle_place(l + 1, 0)].real();
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

// Coefficients of each component of the field or gradient, and the factors a and b of
// HarmonicRecurrence, all as triangular arrays.
struct Series {
  const double* const* coefficients;
  const double *factor_a, *factor_b;
  double inverse_radius;  // [1/m]
  int highest;            // highest degree
};

Series series_of(const double* const* coefficients, double radius, int highest) {
  const HarmonicRecurrence& table = harmonic_recurrence();
  return {coefficients, table.a.data(), table.b.data(), 1.0 / radius, highest};
}

// Sums the harmonics of degree 1 to `highest`, without degrees that are negligible at the distance
// of a point, as in multipole_expansion.cpp. Values at points inside the sphere are meaningless;
// the callers overwrite them.
template <int components, class Lanes>
LOOMSTONE_INLINE void evaluate(Series series, const double* points, Index n, double* out) {
  const auto [coefficients, factor_a, factor_b, inverse_radius, highest] = series;
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
    Lanes real[2][top + 1], imaginary[2][top + 1];  // harmonics of degrees l and l - 1 in the loop
    real[0][0] = lanes_sqrt(inverse);
    imaginary[0][0] = Lanes{};
    p.x *= inverse;
    p.y *= inverse;
    p.z *= inverse;
    for (int l = 1; l <= last; ++l) {
      Lanes* re = real[l & 1];
      Lanes* im = imaginary[l & 1];  // contains degree l - 2 on entry
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
LOOMSTONE_INLINE void field_kernel(Series series, const double* points, Index n, double* out) {
  evaluate<3, Lanes>(series, points, n, out);
}

template <class Lanes>
LOOMSTONE_INLINE void gradient_kernel(Series series, const double* points, Index n, double* out) {
  evaluate<6, Lanes>(series, points, n, out);
}

}  // namespace

HarmonicSphere::HarmonicSphere(double radius, std::shared_ptr<const SphericalHarmonics> series,
                               std::shared_ptr<const SphericalHarmonics> samples,
                               Vector coefficients)
    : radius_(radius),
      series_(std::move(series)),
      samples_(std::move(samples)),
      coefficients_(std::move(coefficients)) {
  const int degree = series_->degree();
  std::vector<Complex> c(triangle_place(degree + 1, 0));
  for (int l = 1; l <= degree; ++l)
    for (int m = 0; m <= l; ++m) {
      const Index k = SphericalHarmonics::slot(l, m);
      c[triangle_place(l, m)] = Complex(coefficients_[k], m > 0 ? coefficients_[k + 1] : 0.0);
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
  LOOMSTONE_WIDEST(field_kernel)(series_of(coefficients, radius_, series_->degree() + 1), points, n,
                                 field);
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
  LOOMSTONE_WIDEST(gradient_kernel)(series_of(coefficients, radius_, series_->degree() + 2), points,
                                    n, gradient);
  for (Index i = 0; i < n; ++i) {
    if (std::hypot(points[i], points[n + i], points[2 * n + i]) >= radius_ * (1.0 - 1e-12))
      continue;
    for (int c = 0; c < 6; ++c) gradient[c * n + i] = 0.0;
  }
}

// Returns the field at a point x inside the sphere; x is in units of the radius a. Inside, the
// potential of the charge has the same coefficients as outside, with (r/a)^l instead of
// (a/r)^(l+1). The magnetisation is the gradient of the harmonic function whose normal derivative
// on the surface is the charge density.
Vec3 HarmonicSphere::inside(const Vec3& x, Quantity quantity) const {
  const HarmonicRecurrence& table = harmonic_recurrence();
  const int degree = series_->degree();
  std::vector<Complex> r(triangle_place(degree + 1, 0));
  r[0] = 1.0;
  Vec3 field = Vec3::Zero();
  for (int l = 1; l <= degree; ++l) {
    for (int m = 0; m < l; ++m)
      r[triangle_place(l, m)] =
          table.a[triangle_place(l, m)] * x.z() * r[triangle_place(l - 1, m)] -
          (m < l - 1 ? table.b[triangle_place(l, m)] * x.squaredNorm() * r[triangle_place(l - 2, m)]
                     : 0.0);
    r[triangle_place(l, l)] =
        table.a[triangle_place(l, l)] * Complex(x.x(), x.y()) * r[triangle_place(l - 1, l - 1)];
    const double share = quantity == Quantity::flux_density ? -(l + 1.0) / l : 1.0;
    for (int m = 0; m <= l; ++m) {
      const Index k = SphericalHarmonics::slot(l, m);
      const Complex c(coefficients_[k], m > 0 ? coefficients_[k + 1] : 0.0);
      // d/dx + i d/dy, d/dx - i d/dy and d/dz of the regular harmonic of degree l and order m.
      const Complex plus = m + 1 <= l - 1 ? -std::sqrt(static_cast<double>(l - m) * (l - m - 1)) *
                                                r[triangle_place(l - 1, m + 1)]
                                          : 0.0;
      const Complex minus = m == 0 ? std::conj(plus)
                                   : std::sqrt(static_cast<double>(l + m) * (l + m - 1)) *
                                         r[triangle_place(l - 1, m - 1)];
      const Complex up =
          m <= l - 1 ? std::sqrt(static_cast<double>(l - m) * (l + m)) * r[triangle_place(l - 1, m)]
                     : 0.0;
      field -= share * Vec3((c * 0.5 * (plus + minus)).real(),
                            (c * Complex(0.0, -0.5) * (plus - minus)).real(), (c * up).real());
    }
  }
  return field;
}

Vec3 HarmonicSphere::moment() const {
  const Index k = SphericalHarmonics::slot(1, 1);
  return 4.0 * pi * radius_ * radius_ * radius_ / mu0 *
         Vec3(coefficients_[k] / std::sqrt(2.0), -coefficients_[k + 1] / std::sqrt(2.0),
              coefficients_[SphericalHarmonics::slot(1, 0)]);
}

// The field of a dipole that points to the centre gives coefficients proportional to
// (l + 1) exp(-x l / 2), where x is SeriesEnd::decay. x follows from the coefficients of two
// degrees, about d / 4 and d / 2, where d is the last degree. Degrees near d are not used, because
// sampling adds the term of degree 2 d + 2 - l to the coefficients of degree l.
SeriesEnd HarmonicSphere::series_end() const {
  const int last = series_->degree(), high = std::max(2, last / 2), low = std::max(1, last / 4);
  if (last < 2) return {last, 0.0};
  const auto squared = [&](int l) {
    return coefficients_.segment(SphericalHarmonics::slot(l, 0), 2 * (l + 1)).squaredNorm() /
           std::pow(l + 1.0, 2);
  };
  if (!(squared(low) > 0.0 && squared(high) > 0.0)) return {last, 0.0};
  return {last, std::log(squared(low) / squared(high)) / (high - low)};
}

// The error is the sum of a geometric series that continues the terms of the charge, multiplied by
// the highest degree (an empirical factor). The sum is the last term times r / (1 - r). The ratio r
// is the squared norm of the coefficients of the last degree divided by that of the degree before
// it, because the contribution of a degree to the force is proportional to this square. If there is
// only one degree, the error is the term of this degree.
Vector HarmonicSphere::charge_errors() const {
  const int last = series_->degree();
  const auto at = [](int l) { return SphericalHarmonics::slot(l, 0); };
  Vector density = Vector::Zero(coefficients_.size());
  density.segment(at(last), 2 * (last + 1)) =
      (2.0 * last + 1.0) / mu0 * coefficients_.segment(at(last), 2 * (last + 1));
  if (last > 1) {
    const double before = coefficients_.segment(at(last - 1), 2 * last).squaredNorm();
    const double after = coefficients_.segment(at(last), 2 * (last + 1)).squaredNorm();
    constexpr double most = 0.99;  // upper bound of the ratio, for series that converge slowly
    const double ratio = before > 0.0 ? std::min(after / before, most) : most;
    density *= last * ratio / (1.0 - ratio);
  }
  return charges_of(density);
}

Vector HarmonicSphere::charges_of(const Vector& density) const {
  Vector padded = Vector::Zero(samples_->size());
  padded.head(density.size()) = density;
  return 4.0 * pi * radius_ * radius_ * samples_->shares().cwiseProduct(samples_->values(padded));
}

std::vector<PanelSample> HarmonicSphere::charges() const {
  Vector density(coefficients_.size());
  for (int l = 1; l <= series_->degree(); ++l) {
    const Index from = SphericalHarmonics::slot(l, 0), n = 2 * (l + 1);
    density.segment(from, n) = (2.0 * l + 1.0) / mu0 * coefficients_.segment(from, n);
  }
  const Vector values = charges_of(density);
  std::vector<PanelSample> result(values.size());
  for (std::size_t i = 0; i < result.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const Vec3 normal = samples_->points().row(row).transpose();
    result[i].position = radius_ * normal;
    result[i].area = 4.0 * pi * radius_ * radius_ * samples_->shares()[row] * normal;
    result[i].charge = values[row];
  }
  return result;
}

}  // namespace loomstone
