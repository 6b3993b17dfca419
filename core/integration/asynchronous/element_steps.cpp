#include "core/integration/asynchronous/element_steps.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "core/base/same_bits.h"

namespace loomstone {

namespace {

// With a limit potential, the step of a triangle is so short that none of its strain components is
// predicted to change by more than this in the step (section 4.2 of [Thomaszewski2010]).
constexpr double largest_change = 0.1;

// Gradients of the linear shape functions (2 x 3) [1/m], rest area [m^2] and inradius [m] of a
// triangle.
struct RestTriangle {
  Eigen::Matrix<double, 2, 3> gradients;
  double area, inradius;

  explicit RestTriangle(const Corners2& c) {
    const Vec2 e1 = (c.row(1) - c.row(0)).transpose(), e2 = (c.row(2) - c.row(0)).transpose();
    const double twice_area = e1.x() * e2.y() - e1.y() * e2.x();
    gradients.col(1) = Vec2(e2.y(), -e2.x()) / twice_area;
    gradients.col(2) = Vec2(-e1.y(), e1.x()) / twice_area;
    gradients.col(0) = -gradients.col(1) - gradients.col(2);
    area = 0.5 * twice_area;
    inradius = twice_area / (e1.norm() + e2.norm() + (e2 - e1).norm());
  }
};

// Product B B^T, where B maps the in-plane displacements u of the corners of a triangle at rest to
// the strains (E11, E22, 2 E12) = B u.
Mat3 strain_product(const RestTriangle& rest) {
  Mat3 product = Mat3::Zero();
  for (int k = 0; k < 3; ++k) {
    const double gx = rest.gradients(0, k), gy = rest.gradients(1, k);
    Mat32 b;
    b << gx, 0.0, 0.0, gy, gy, gx;
    product += b * b.transpose();
  }
  return product;
}

// Largest eigenvalue of B^T C B, where C is the matrix of moduli, and B is defined as in
// strain_product().
double largest_eigenvalue(const RestTriangle& rest, const Mat3& moduli) {
  const Eigen::SelfAdjointEigenSolver<Mat3> split(moduli);
  const Mat3 root = split.eigenvectors() *
                    split.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() *
                    split.eigenvectors().transpose();
  return Eigen::SelfAdjointEigenSolver<Mat3>(root * strain_product(rest) * root,
                                             Eigen::EigenvaluesOnly)
      .eigenvalues()
      .maxCoeff();
}

// Inner products of the vectors sqrt(k) B^T d, where k and d are the modulus and direction of each
// of the three limit modes, and B is defined as in strain_product(). The matrix has the nonzero
// eigenvalues of the stiffness B^T (sum k d d^T) B that the second phases of all three modes add
// (see LimitMode).
Mat3 limit_products(const RestTriangle& rest, const LimitModes& limits) {
  Mat3 directions;
  for (int k = 0; k < 3; ++k)
    directions.col(k) =
        std::sqrt(limits[k].modulus) * Vec3(limits[k].d11, limits[k].d22, limits[k].d12);
  return directions.transpose() * strain_product(rest) * directions;
}

LimitPhases later(const LimitPhases& a, const LimitPhases& b) {
  return {std::max(a[0], b[0]), std::max(a[1], b[1]), std::max(a[2], b[2])};
}

Mat3 elastic_moduli(const MembraneConstants& m) {
  Mat3 moduli;
  moduli << m.a11, m.a12, 0.0, m.a12, m.a22, 0.0, 0.0, 0.0, m.g;
  return moduli;
}

Mat3 viscous_moduli(const MembraneConstants& m) {
  Mat3 moduli;
  const double sum = m.lambda_d + 2.0 * m.mu_d;
  moduli << sum, m.lambda_d, 0.0, m.lambda_d, sum, 0.0, 0.0, 0.0, m.mu_d;
  return moduli;
}

// Largest stiffness for a plane wave in any direction [N/m]: the largest eigenvalue of the acoustic
// tensor, sampled at one direction per degree. For isotropic cloth this is lambda + 2 mu, as in
// (4.26) of [Thomaszewski2010].
double wave_stiffness(const MembraneConstants& m) {
  constexpr int directions = 180;
  double largest = 0.0;
  for (int i = 0; i < directions; ++i) {
    const double c = std::cos(M_PI * i / directions), s = std::sin(M_PI * i / directions);
    const double t11 = m.a11 * c * c + m.g * s * s, t22 = m.a22 * s * s + m.g * c * c,
                 t12 = (m.a12 + m.g) * c * s;
    largest = std::max(largest, 0.5 * (t11 + t22) + std::hypot(0.5 * (t11 - t22), t12));
  }
  return largest;
}

}  // namespace

ElementSteps::ElementSteps(const ClothModel& model, const Asynchronous& options,
                           const std::vector<LimitModes>& limits)
    : model_(model), limits_(limits) {
  const auto m = static_cast<Index>(model.triangles.rows());
  share_.resize(m, 3), at_rest_.resize(m), tension_ = Vector::Zero(m), stretch_ = Vector::Ones(m);
  phases_.assign(m, {});
  std::vector<RestTriangle> rest;
  Vector area = Vector::Zero(model.n_vertices);  // total area of the triangles at each vertex [m^2]
  for (Index t = 0; t < m; ++t) {
    rest.emplace_back(model.corners[t]);
    for (int k = 0; k < 3; ++k) area[model.triangles(t, k)] += rest[t].area;
  }
  for (Index t = 0; t < m; ++t) {
    const MembraneConstants& material = model.constants_of(t);
    double density = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k) {
      const Index vertex = model.triangles(t, k);
      share_(t, k) = rest[t].area / area[vertex];
      density = std::min(density, 3.0 * model.mass[vertex] / area[vertex]);
    }
    // Area of the triangle divided by the smallest mass that it contributes to a corner [m^2/kg].
    const double scale = 3.0 / density;
    const Mat2 gradients = rest[t].gradients * rest[t].gradients.transpose();
    Element element;
    element.eigenvalue = scale * largest_eigenvalue(rest[t], elastic_moduli(material));
    if (!limits.empty()) limit_products_.emplace_back(scale * limit_products(rest[t], limits[t]));
    element.viscous_eigenvalue = scale * largest_eigenvalue(rest[t], viscous_moduli(material));
    element.tension_eigenvalue =
        scale * Eigen::SelfAdjointEigenSolver<Mat2>(gradients).eigenvalues().maxCoeff();
    element.safety = options.given_safety();
    if (options.limit == StepLimit::Inradius) {
      // `time` is the bound (4.26) of [Thomaszewski2010]. The stability limit without viscosity is
      // 2 / sqrt(eigenvalue).
      const double time = rest[t].inradius * std::sqrt(density / wave_stiffness(material));
      element.safety *= 0.5 * time * std::sqrt(element.eigenvalue);
    }
    elements_.push_back(element);
    at_rest_[t] = step(t, {}, element.safety);
  }
}

double ElementSteps::step(Index t, const LimitPhases& phases, double safety) const {
  const Element& element = elements_[t];
  const double square = std::max(1.0, stretch_[t] * stretch_[t]);
  double eigenvalue = element.eigenvalue;
  if (phases[0] + phases[1] + phases[2] > 0) eigenvalue += largest_of_phases(t, phases);
  const double k = square * eigenvalue + tension_[t] * element.tension_eigenvalue;
  const double d = square * element.viscous_eigenvalue;
  return (std::sqrt(d * d + 4.0 * safety * safety * k) - d) / k;
}

// Returns the largest eigenvalue of the stiffness, divided by mass, that the limit modes of
// triangle t add if they are in the given phases [1/s^2].
double ElementSteps::largest_of_phases(Index t, const LimitPhases& phases) const {
  constexpr double modulus[3] = {0.0, 1.0, 1.0 + LimitMode::steeper};
  Vec3 root;
  for (int k = 0; k < 3; ++k) root[k] = std::sqrt(modulus[phases[k]]);
  const Mat3 product = root.asDiagonal() * limit_products_[t] * root.asDiagonal();
  Eigen::SelfAdjointEigenSolver<Mat3> split;
  return split.computeDirect(product, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff();
}

double ElementSteps::step_in_phases(Index t, const LimitPhases& phases) const {
  return step(t, later(phases_[t], phases), elements_[t].safety);
}

LimitPhases ElementSteps::phases_at(Index t, const Points& green) const {
  LimitPhases phases;
  for (int k = 0; k < 3; ++k) {
    const LimitMode& mode = limits_[t][k];
    phases[k] =
        static_cast<std::uint8_t>(mode.phase(mode.strain(green(t, 0), green(t, 1), green(t, 2))));
  }
  return phases;
}

// Computes the strains, stretches and tensions at x and, with a limit potential, the limit phases.
// Does nothing if x is the same as in the last call.
void ElementSteps::measure(const Team& team, const Points& x, Elasticity& elasticity) {
  if (same_bits(x, x_)) return;
  elasticity.strain(team, x, green_, stretch_);
  x_ = x;
  parallel_for(team, static_cast<Index>(elements_.size()), [&](Index t) {
    const MembraneConstants& m = model_.constants_of(t);
    const double e11 = green_(t, 0), e22 = green_(t, 1), e12 = green_(t, 2);
    double s11 = m.a11 * e11 + m.a12 * e22, s22 = m.a22 * e22 + m.a12 * e11, s12 = 2.0 * m.g * e12;
    if (!limits_.empty()) {
      phases_[t] = phases_at(t, green_);
      for (const LimitMode& mode : limits_[t]) {
        const double stress = mode.stress(mode.strain(e11, e22, e12));
        s11 += stress * mode.d11, s22 += stress * mode.d22, s12 += stress * mode.d12;
      }
    }
    const double d = 0.5 * (s11 - s22);
    tension_[t] = std::max(0.0, 0.5 * (s11 + s22) + std::sqrt(d * d + s12 * s12));
  });
}

const Vector& ElementSteps::at(const Team& team, const Points& x, const Points& v,
                               Elasticity& elasticity) {
  measure(team, x, elasticity);
  const double ahead = at_rest_.maxCoeff();
  if (!limits_.empty()) {
    next_x_ = x + ahead * v;
    elasticity.strain(team, next_x_, next_green_, next_stretch_);
  }
  at_.resize(at_rest_.size());
  parallel_for(team, static_cast<Index>(elements_.size()), [&](Index t) {
    if (limits_.empty()) {
      at_[t] = step(t, {}, elements_[t].safety);
      return;
    }
    at_[t] = step_in_phases(t, phases_at(t, next_green_));
    const double change = (next_green_.row(t) - green_.row(t)).cwiseAbs().maxCoeff();
    if (change * at_[t] > largest_change * ahead) at_[t] = largest_change * ahead / change;
  });
  return at_;
}

Index ElementSteps::first_unstable(const Team& team, const Points& x, const Vector& steps,
                                   Elasticity& elasticity) {
  measure(team, x, elasticity);
  for (Index t = 0; t < static_cast<Index>(elements_.size()); ++t) {
    const bool finite = std::isfinite(stretch_[t]);
    if (!finite || !(steps[t] <= step(t, phases_[t], 1.0))) return t;
  }
  return -1;
}

}  // namespace loomstone
