#include "core/magnetics/induction/soft_shape.h"

#include <algorithm>
#include <cmath>

#include "core/base/message.h"
#include "core/magnetics/sources/constants.h"
#include "core/magnetics/sources/harmonic_sphere.h"
#include "core/magnetics/sources/sphere.h"

namespace loomstone {

namespace {

// The field on a sphere is projected onto harmonics by a quadrature rule. The rule is exact for
// products of two harmonics whose degrees are at most that of the sphere or least_of_samples,
// whichever is higher. With a rule for degree 1, higher harmonics of a field that varies over the
// sphere would count as a uniform field. The value is our choice: with the rule for degree 5, the
// relative error of the moment of a sphere of degree 1 at 2.8 radii from a magnet is 2e-4.
constexpr int least_of_samples = 5;

class SphereOfHarmonics final : public SoftShape {
 public:
  SphereOfHarmonics(double radius, double susceptibility, int degree)
      : radius_(radius),
        susceptibility_(susceptibility),
        degree_(degree),
        series_(std::make_shared<const SphericalHarmonics>(std::max(degree, 1))),
        sampled_(degree >= least_of_samples
                     ? series_
                     : std::make_shared<const SphericalHarmonics>(least_of_samples)),
        samples_(radius * sampled_->points()) {}

  const Points& samples() const override { return samples_; }
  Vector received(const Points& field) const override {
    Vector result =
        sampled_->coefficients((field.array() * sampled_->points().array()).rowwise().sum())
            .head(series_->size());
    for (int l = 1; l <= series_->degree(); ++l)  // H_r = -d(potential)/dr
      result.segment(SphericalHarmonics::slot(l, 0), 2 * (l + 1)) /= -l;
    return result;
  }
  Vector response(const Vector& received) const override {
    Vector result = received;
    for (int l = 1; l <= series_->degree(); ++l) {
      // This form of l chi / (l chi + 2 l + 1) is also valid for infinite chi.
      const double share = susceptibility_ > 1.0
                               ? l / (l + (2.0 * l + 1.0) / susceptibility_)
                               : l * susceptibility_ / (l * susceptibility_ + 2.0 * l + 1.0);
      result.segment(SphericalHarmonics::slot(l, 0), 2 * (l + 1)) *= -share;
    }
    return result;
  }
  SourcePtr source(const Vector& charges) const override {
    return std::make_shared<HarmonicSphere>(radius_, series_, sampled_, charges);
  }
  Vec3 mean_field(const Vector& received) const override {
    const Index k = SphericalHarmonics::slot(1, 1);
    return {-received[k] / std::sqrt(2.0), received[k + 1] / std::sqrt(2.0),
            -received[SphericalHarmonics::slot(1, 0)]};
  }
  double volume() const override { return 4.0 / 3.0 * pi * radius_ * radius_ * radius_; }
  double radius() const override { return radius_; }
  SourcePtr solid() const override { return std::make_shared<Sphere>(radius_, Vec3(0, 0, 1)); }
  double susceptibility() const override { return susceptibility_; }
  SoftShapePtr with_susceptibility(double susceptibility) const override {
    return std::make_shared<SphereOfHarmonics>(radius_, susceptibility, degree_);
  }
  int sphere_degree() const override { return degree_; }
  SourceRecipe recipe() const override {
    return {"soft_sphere",
            {{"radius", radius_},
             {"susceptibility", susceptibility_},
             {"degree", static_cast<double>(degree_)}},
            {},
            {}};
  }

 private:
  double radius_, susceptibility_;
  int degree_;
  // Harmonics of the response and of the samples.
  std::shared_ptr<const SphericalHarmonics> series_, sampled_;
  Points samples_;
};

}  // namespace

SourcePtr SoftShape::source(const Vector& charges, const AppliedField&) const {
  return source(charges);
}

void check_susceptibility(double susceptibility) {
  if (!(susceptibility >= -1.0) || susceptibility == 0.0)
    fail<InvalidInput>(
        "susceptibility must be >= -1 (a superconductor) and other than 0 [1], got {}",
        susceptibility);
}

SoftShapePtr soft_sphere(double radius, double susceptibility, int degree) {
  check_susceptibility(susceptibility);
  if (!(radius > 0.0) || !std::isfinite(radius))
    fail<InvalidInput>("radius must be > 0 [m], got {}", radius);
  if (degree < 0 || degree > SphericalHarmonics::most)
    fail<InvalidInput>("degree must be between 0 (automatic) and {}, got {}",
                       SphericalHarmonics::most, degree);
  return std::make_shared<SphereOfHarmonics>(radius, susceptibility, degree);
}

}  // namespace loomstone
