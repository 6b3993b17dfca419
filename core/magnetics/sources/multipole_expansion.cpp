// Moments and evaluation of solid-harmonic expansions. The recurrences are those of [Wang1996],
// section II.
#include "core/magnetics/sources/multipole_expansion.h"

#include <cmath>
#include <cstdlib>

#include "core/magnetics/sources/constants.h"
#include "core/magnetics/sources/lane_math.h"

namespace loomstone {

namespace {

constexpr int gradient_degree = MultipoleExpansion::degree + 2;  // highest degree of the gradient
constexpr int size =
    (gradient_degree + 1) * (gradient_degree + 2) / 2;  // number of harmonics with m >= 0
constexpr int slot(int l, int m) { return l * (l + 1) / 2 + m; }

using Coefficients = std::vector<std::complex<double>>;

// Computes the regular harmonics R_lm = r^l P_lm exp(i m phi) / (l+m)! up to `degree`.
void regular_harmonics(const Vec3& r, Coefficients& out) {
  const std::complex<double> xy(r.x(), r.y());
  const double square = r.squaredNorm();
  for (int m = 0; m <= MultipoleExpansion::degree; ++m) {
    out[slot(m, m)] = m == 0 ? 1.0 : xy / (2.0 * m) * out[slot(m - 1, m - 1)];
    if (m < MultipoleExpansion::degree) out[slot(m + 1, m)] = r.z() * out[slot(m, m)];
    for (int l = m + 2; l <= MultipoleExpansion::degree; ++l)
      out[slot(l, m)] =
          ((2.0 * l - 1.0) * r.z() * out[slot(l - 1, m)] - square * out[slot(l - 2, m)]) /
          double((l + m) * (l - m));
  }
}

// Returns the coefficients of minus the derivative of sum Re(c_lm S_lm) along an axis.
Coefficients minus_derivative(const Coefficients& c, int axis) {
  const std::complex<double> i(0.0, 1.0);
  Coefficients d(size);
  for (int l = 0; l < gradient_degree; ++l) {
    for (int m = 0; m <= l; ++m) {
      const std::complex<double> value = c[slot(l, m)];
      if (axis == 2) {
        d[slot(l + 1, m)] += value;
      } else if (m == 0) {
        d[slot(l + 1, 1)] += axis == 0 ? value : -i * value;
      } else {
        d[slot(l + 1, m + 1)] += axis == 0 ? 0.5 * value : -0.5 * i * value;
        d[slot(l + 1, m - 1)] -= axis == 0 ? 0.5 * value : 0.5 * i * value;
      }
    }
    d[slot(l + 1, 0)] = d[slot(l + 1, 0)].real();  // S_l0 is real
  }
  return d;
}

std::vector<double> flattened(const Coefficients& c, double scale) {
  std::vector<double> out(2 * size);
  for (int k = 0; k < size; ++k) {
    out[2 * k] = scale * c[k].real();
    out[2 * k + 1] = -scale * c[k].imag();  // Re(c S) = Re c Re S - Im c Im S
  }
  return out;
}

// Sums the harmonics for all `components` at once. Each lane adds exactly the degrees that its own
// distance requires, so the value at a point does not depend on the other points of its block.
template <int components, class Lanes>
LOOMSTONE_INLINE void evaluate(const double* const* coefficients, double inverse_radius,
                               const double* points, Index n, int highest, double* out) {
  for (Index i = 0; i < n; i += n_lanes) {
    Lanes3<Lanes> p{lanes_load<Lanes>(points + i) * inverse_radius,
                    lanes_load<Lanes>(points + n + i) * inverse_radius,
                    lanes_load<Lanes>(points + 2 * n + i) * inverse_radius};
    Lanes square = dot(p, p);
    // The distance is clamped to at least two radii. Closer points get finite values that are not
    // used.
    const MaskOf<Lanes> inside = square < 4.0;
    square = lanes_select(inside, lanes_all<Lanes>(4.0), square);
    const Lanes inverse = 1.0 / square, distance = lanes_sqrt(square);
    // The leading term has degree 2 (field) or 3 (gradient). Degrees l are omitted if
    // distance^(3 - l) <= exp(-39), about 1e-17. The distance is in radii.
    const Lanes needed = 39.0 / lanes_log(distance) + 3.0;
    int last = 0;
    for (int lane = 0; lane < n_lanes; ++lane)
      last = needed[lane] > last ? static_cast<int>(needed[lane]) + 1 : last;
    last = last < highest ? last : highest;
    Lanes sum[components];
    for (Lanes& s : sum) s = Lanes{};
    Lanes real[2][gradient_degree + 1],
        imaginary[2][gradient_degree + 1];  // values of degrees l and l - 1
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
      for (int m = 0; m <= l - 2; ++m) {
        const Lanes a = (2.0 * l - 1.0) * p.z;
        const Lanes b = static_cast<double>((l - 1 + m) * (l - 1 - m)) * inverse;
        re[m] = a * re1[m] - b * re[m];
        im[m] = a * im1[m] - b * im[m];
      }
      re[l - 1] = (2.0 * l - 1.0) * p.z * re1[l - 1];
      im[l - 1] = (2.0 * l - 1.0) * p.z * im1[l - 1];
      re[l] = (2.0 * l - 1.0) * (p.x * re1[l - 1] - p.y * im1[l - 1]);
      im[l] = (2.0 * l - 1.0) * (p.x * im1[l - 1] + p.y * re1[l - 1]);
      const MaskOf<Lanes> wanted = needed > static_cast<double>(l);
      for (int c = 0; c < components; ++c) {
        const double* value = coefficients[c] + 2 * slot(l, 0);
        Lanes part{};
        for (int m = 0; m <= l; ++m) part += value[2 * m] * re[m] + value[2 * m + 1] * im[m];
        sum[c] += lanes_select(wanted, part, Lanes{});
      }
    }
    for (int c = 0; c < components; ++c) lanes_store(out + c * n + i, sum[c]);
  }
}

template <class Lanes>
LOOMSTONE_INLINE void field_kernel(const double* const* coefficients, double inverse_radius,
                                   const double* points, Index n, double* out) {
  evaluate<3, Lanes>(coefficients, inverse_radius, points, n, MultipoleExpansion::degree + 1, out);
}

template <class Lanes>
LOOMSTONE_INLINE void gradient_kernel(const double* const* coefficients, double inverse_radius,
                                      const double* points, Index n, double* out) {
  evaluate<6, Lanes>(coefficients, inverse_radius, points, n, MultipoleExpansion::degree + 2, out);
}

// Adds c times the complex conjugates of the harmonics h to `moments`. Terms with m > 0 are doubled
// to include those with -m.
void add_moments(double c, const Coefficients& h, Coefficients& moments) {
  for (int l = 0; l <= MultipoleExpansion::degree; ++l)
    for (int m = 0; m <= l; ++m)
      moments[slot(l, m)] += c * (m == 0 ? 1.0 : 2.0) * std::conj(h[slot(l, m)]);
}

Coefficients moments_of(const Points& positions, const Vector& charges, double radius) {
  Coefficients moments(size), harmonics(size);
  for (Eigen::Index i = 0; i < positions.rows(); ++i) {
    regular_harmonics(positions.row(i).transpose() / radius, harmonics);
    add_moments(charges[i], harmonics, moments);
  }
  return moments;
}

// Returns the derivatives of the regular harmonics along a direction, from
//   (d/dx - i d/dy) R_lm = R_{l-1,m-1}, (d/dx + i d/dy) R_lm = -R_{l-1,m+1}, d/dz R_lm = R_{l-1,m}.
Coefficients along(const Coefficients& harmonics, const Vec3& direction) {
  const std::complex<double> i(0.0, 1.0);
  Coefficients d(size);
  for (int l = 1; l <= MultipoleExpansion::degree; ++l) {
    for (int m = 0; m <= l; ++m) {
      const auto at = [&](int order) -> std::complex<double> {
        if (order < 0) return -std::conj(harmonics[slot(l - 1, -order)]);  // R_l,-1 = -conj(R_l1)
        return order < l ? harmonics[slot(l - 1, order)] : 0.0;
      };
      const std::complex<double> less = at(m - 1), more = -at(m + 1);
      d[slot(l, m)] = 0.5 * direction[0] * (less + more) + 0.5 * direction[1] * i * (less - more) +
                      direction[2] * at(m);
    }
  }
  return d;
}

}  // namespace

MultipoleExpansion::MultipoleExpansion(const Points& positions, const Vector& charges,
                                       double radius)
    : MultipoleExpansion(moments_of(positions, charges, radius), radius) {}

MultipoleExpansion MultipoleExpansion::of_dipoles(const Points& positions, const Points& moments,
                                                  double radius) {
  Coefficients sums(size), harmonics(size);
  for (Eigen::Index i = 0; i < positions.rows(); ++i) {
    regular_harmonics(positions.row(i).transpose() / radius, harmonics);
    add_moments(1.0, along(harmonics, moments.row(i).transpose() / radius), sums);
  }
  return MultipoleExpansion(std::move(sums), radius);
}

MultipoleExpansion::MultipoleExpansion(std::vector<std::complex<double>> moments, double radius)
    : radius_(radius) {
  moments[0] = 0.0;  // a magnet has no net charge
  const double scale = 1.0 / (4.0 * pi * radius * radius);
  int k = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const Coefficients field = minus_derivative(moments, axis);
    field_[axis] = flattened(field, scale);
    for (int second = axis; second < 3; ++second) {
      Coefficients derivative = minus_derivative(field, second);
      gradient_[k++] = flattened(derivative, -scale / radius);
    }
  }
}

void MultipoleExpansion::field_block(const double* points, Index n, double* field) const {
  const double* coefficients[3] = {field_[0].data(), field_[1].data(), field_[2].data()};
  LOOMSTONE_WIDEST(field_kernel)(coefficients, 1.0 / radius_, points, n, field);
}

void MultipoleExpansion::gradient_block(const double* points, Index n, double* gradient) const {
  const double* coefficients[6];
  for (int c = 0; c < 6; ++c) coefficients[c] = gradient_[c].data();
  LOOMSTONE_WIDEST(gradient_kernel)(coefficients, 1.0 / radius_, points, n, gradient);
}

}  // namespace loomstone
