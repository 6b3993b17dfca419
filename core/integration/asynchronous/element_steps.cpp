#include "core/integration/asynchronous/element_steps.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <Eigen/Eigenvalues>

namespace loomstone {

namespace {

// Gradients of the linear shape functions (2 x 3) [1/m] and rest area of a triangle.
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

// Largest eigenvalue of B^T C B for the strains (E11, E22, 2 E12) = B u of in-plane motion at rest.
double largest_eigenvalue(const RestTriangle& rest, const Mat3& moduli) {
  Mat3 bb = Mat3::Zero();  // B B^T
  for (int k = 0; k < 3; ++k) {
    const double gx = rest.gradients(0, k), gy = rest.gradients(1, k);
    Mat32 b;
    b << gx, 0.0, 0.0, gy, gy, gx;
    bb += b * b.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Mat3> split(moduli);
  const Mat3 root = split.eigenvectors() *
                    split.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() *
                    split.eigenvectors().transpose();
  return Eigen::SelfAdjointEigenSolver<Mat3>(root * bb * root, Eigen::EigenvaluesOnly)
      .eigenvalues()
      .maxCoeff();
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

// Largest stiffness against plane waves in any direction [N/m]: largest eigenvalue of the acoustic
// tensor. For isotropic cloth this is lambda + 2 mu of (4.26).
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

ElementSteps::ElementSteps(const ClothModel& model, const Asynchronous& options) : model_(model) {
  const auto m = static_cast<Index>(model.triangles.rows());
  share_.resize(m, 3), at_rest_.resize(m), tension_.resize(m);
  std::vector<RestTriangle> rest;
  Vector area = Vector::Zero(model.n_vertices);  // of the triangles at each vertex
  for (Index t = 0; t < m; ++t) {
    rest.emplace_back(model.corners[t]);
    for (int k = 0; k < 3; ++k) area[model.triangles(t, k)] += rest[t].area;
  }
  for (Index t = 0; t < m; ++t) {
    const MembraneConstants& material = model.constants[t];
    double density = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k) {
      const Index vertex = model.triangles(t, k);
      share_(t, k) = rest[t].area / area[vertex];
      density = std::min(density, 3.0 * model.mass[vertex] / area[vertex]);
    }
    const double scale = 3.0 / density;  // area of the triangle divided by the mass of a corner
    const Mat2 gradients = rest[t].gradients * rest[t].gradients.transpose();
    Element element;
    element.eigenvalue = scale * largest_eigenvalue(rest[t], elastic_moduli(material));
    element.viscous_eigenvalue = scale * largest_eigenvalue(rest[t], viscous_moduli(material));
    element.tension_eigenvalue =
        scale * Eigen::SelfAdjointEigenSolver<Mat2>(gradients).eigenvalues().maxCoeff();
    element.safety = options.given_safety();
    if (options.limit == StepLimit::Inradius) {  // (4.26), as a share of the limit of stability
      const double time = rest[t].inradius * std::sqrt(density / wave_stiffness(material));
      element.safety *= 0.5 * time * std::sqrt(element.eigenvalue);
    }
    elements_.push_back(element);
    at_rest_[t] = step(element, 1.0, 0.0, element.safety);
  }
}

double ElementSteps::step(const Element& element, double stretch_square, double tension,
                          double safety) const {
  const double k = stretch_square * element.eigenvalue + tension * element.tension_eigenvalue;
  const double d = stretch_square * element.viscous_eigenvalue;
  return (std::sqrt(d * d + 4.0 * safety * safety * k) - d) / k;
}

// Finds the strains at x, unless they are known.
void ElementSteps::measure(const Team& team, const Points& x, Elasticity& elasticity) {
  if (x.rows() == x_.rows() && std::memcmp(x.data(), x_.data(), sizeof(double) * x.size()) == 0)
    return;
  elasticity.strain(team, x, green_, stretch_);
  x_ = x;
  parallel_for(team, static_cast<Index>(elements_.size()), [&](Index t) {
    const MembraneConstants& m = model_.constants[t];
    const double e11 = green_(t, 0), e22 = green_(t, 1), e12 = green_(t, 2);
    const double s11 = m.a11 * e11 + m.a12 * e22, s22 = m.a22 * e22 + m.a12 * e11,
                 s12 = 2.0 * m.g * e12;
    const double d = 0.5 * (s11 - s22);
    tension_[t] = std::max(0.0, 0.5 * (s11 + s22) + std::sqrt(d * d + s12 * s12));
  });
}

const Vector& ElementSteps::at(const Team& team, const Points& x, Elasticity& elasticity) {
  measure(team, x, elasticity);
  at_.resize(at_rest_.size());
  parallel_for(team, static_cast<Index>(elements_.size()), [&](Index t) {
    const double square = std::max(1.0, stretch_[t] * stretch_[t]);
    at_[t] = step(elements_[t], square, tension_[t], elements_[t].safety);
  });
  return at_;
}

Index ElementSteps::first_unstable(const Team& team, const Points& x, const Vector& steps,
                                   Elasticity& elasticity) {
  measure(team, x, elasticity);
  for (Index t = 0; t < static_cast<Index>(elements_.size()); ++t) {
    const double square = std::max(1.0, stretch_[t] * stretch_[t]);
    const bool finite = std::isfinite(stretch_[t]);
    if (!finite || !(steps[t] <= step(elements_[t], square, tension_[t], 1.0))) return t;
  }
  return -1;
}

}  // namespace loomstone
