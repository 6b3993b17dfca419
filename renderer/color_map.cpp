// viridis and magma are polynomials of degree 6 that Matt Zucker fitted to the tables of Smith and
// van der Walt ("Polynomial colormaps", 2019, CC0). They deviate from the tables by at most 5 of
// 255. diverging is the cool-to-warm map of K. Moreland, "Diverging Color Maps for Scientific
// Visualization", 2009, which interpolates in polar CIELAB through an unsaturated middle.
#include "renderer/color_map.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "core/base/types.h"

namespace loomstone {
namespace {

using Coefficients = std::array<Vec3, 7>;  // RGB coefficients of 1, t, ..., t^6

const Coefficients viridis = {Vec3(0.2777273272234177, 0.005407344544966578, 0.3340998053353061),
                              Vec3(0.1050930431085774, 1.404613529898575, 1.384590162594685),
                              Vec3(-0.3308618287255563, 0.214847559468213, 0.09509516302823659),
                              Vec3(-4.634230498983486, -5.799100973351585, -19.33244095627987),
                              Vec3(6.228269936347081, 14.17993336680509, 56.69055260068105),
                              Vec3(4.776384997670288, -13.74514537774601, -65.35303263337234),
                              Vec3(-5.435455855934631, 4.645852612178535, 26.3124352495832)};

const Coefficients magma = {
    Vec3(-0.002136485053939582, -0.000749655052795221, -0.005386127855323933),
    Vec3(0.2516605407371642, 0.6775232436837668, 2.494026599312351),
    Vec3(8.353717279216625, -3.577719514958484, 0.3144679030132573),
    Vec3(-27.66873308576866, 14.26473078096533, -13.64921318813922),
    Vec3(52.17613981234068, -27.94360607168351, 12.94416944238394),
    Vec3(-50.76852536473588, 29.04658282127291, 4.23415299384598),
    Vec3(18.65570506591883, -11.48977351997711, -5.601961508734096)};

Vec3 polynomial(const Coefficients& c, double t) {
  Vec3 sum = c[6];
  for (int power = 5; power >= 0; --power) sum = sum * t + c[power];
  return sum;
}

double to_linear(double srgb) {
  return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}
double to_srgb(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
}

const Vec3 white(0.95047, 1.0, 1.08883);  // XYZ of the white point D65

const Mat3& xyz_of_rgb() {
  static const Mat3 matrix =
      (Mat3() << 0.4124, 0.3576, 0.1805, 0.2126, 0.7152, 0.0722, 0.0193, 0.1192, 0.9505).finished();
  return matrix;
}

// Polar CIELAB coordinates (Msh): magnitude, saturation angle and hue angle.
Vec3 msh_of_srgb(const Vec3& srgb) {
  const Vec3 xyz = (xyz_of_rgb() * srgb.unaryExpr(&to_linear)).cwiseQuotient(white);
  const Vec3 f = xyz.unaryExpr(
      [](double v) { return v > 0.008856 ? std::cbrt(v) : 7.787 * v + 16.0 / 116.0; });
  const Vec3 lab(116.0 * f.y() - 16.0, 500.0 * (f.x() - f.y()), 200.0 * (f.y() - f.z()));
  const double magnitude = lab.norm();
  return {magnitude, std::acos(lab.x() / magnitude), std::atan2(lab.z(), lab.y())};
}

Vec3 srgb_of_msh(const Vec3& msh) {
  const Vec3 lab(msh[0] * std::cos(msh[1]), msh[0] * std::sin(msh[1]) * std::cos(msh[2]),
                 msh[0] * std::sin(msh[1]) * std::sin(msh[2]));
  const double fy = (lab.x() + 16.0) / 116.0;
  const Vec3 f(fy + lab.y() / 500.0, fy, fy - lab.z() / 200.0);
  const Vec3 xyz = f.unaryExpr([](double v) {
                      return v > 0.206893 ? v * v * v : (v - 16.0 / 116.0) / 7.787;
                    }).cwiseProduct(white);
  return (xyz_of_rgb().inverse() * xyz).unaryExpr(&to_srgb);
}

// Hue of the unsaturated middle colour for interpolation to a saturated end colour. Colours are in
// Msh coordinates (Moreland, function AdjustHue).
double adjusted_hue(const Vec3& saturated, double middle_magnitude) {
  if (saturated[0] >= middle_magnitude) return saturated[2];
  const double spin = saturated[1] *
                      std::sqrt(middle_magnitude * middle_magnitude - saturated[0] * saturated[0]) /
                      (saturated[0] * std::sin(saturated[1]));
  return saturated[2] > -3.14159265358979323846 / 3.0 ? saturated[2] + spin : saturated[2] - spin;
}

Vec3 cool_to_warm(double t) {
  const Vec3 end = msh_of_srgb(t < 0.5 ? Vec3(0.230, 0.299, 0.754) : Vec3(0.706, 0.016, 0.150));
  const double middle_magnitude = 88.0;
  const Vec3 middle(middle_magnitude, 0.0, adjusted_hue(end, middle_magnitude));
  const double share = std::abs(2.0 * t - 1.0);  // 0 in the middle, 1 at the ends
  return srgb_of_msh(share * end + (1.0 - share) * middle);
}

}  // namespace

ColorTable color_table(ColorMap map) {
  Vec3 (*color)(double) = nullptr;
  switch (map) {
    case ColorMap::Viridis:
      color = [](double t) { return polynomial(viridis, t); };
      break;
    case ColorMap::Magma:
      color = [](double t) { return polynomial(magma, t); };
      break;
    case ColorMap::Diverging:
      color = cool_to_warm;
      break;
  }
  ColorTable table;
  for (int i = 0; i < 256; ++i) {
    const Vec3 rgb = color(i / 255.0);
    for (int channel = 0; channel < 3; ++channel)
      table[i][channel] =
          static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(rgb[channel], 0.0, 1.0)));
  }
  return table;
}

}  // namespace loomstone
